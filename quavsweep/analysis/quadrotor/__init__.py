"""What is known of the quadrotor's attitude in closed form, and measures of its energy."""
