"""Pictures as files: headers, JPEG and PNG, folders of them."""
