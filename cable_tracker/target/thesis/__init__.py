"""The filter of J. Ha (2008): a blob with a fast contour per particle."""
