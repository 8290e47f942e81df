"""What commands say, how they are found and stopped, and what they need beside Python."""
