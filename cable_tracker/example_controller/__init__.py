"""An example of a controller that follows the cable by `cross_track`; no part of the tracker."""
