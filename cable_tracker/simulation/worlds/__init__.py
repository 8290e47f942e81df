"""Fast pictures of strips over a bottom: hard frames with exact truth, to tune on or report on."""
