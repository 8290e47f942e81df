"""Where frames come from and go to: bags, videos, folders of pictures, image-sequence files."""
