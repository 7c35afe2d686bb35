"""What the fields are made with on the host: weights of filters, coefficients of splines, pre-filtered levels."""
