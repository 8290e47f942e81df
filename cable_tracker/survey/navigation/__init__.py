"""Where the vehicle was: poses from odometry, laid on the earth by fixes."""
