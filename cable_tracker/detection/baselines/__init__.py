"""Detectors that evaluation, surveys and the option `--init` use, not the tracker itself."""
