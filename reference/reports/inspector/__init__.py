"""Looking into a run: one page with its reservoirs, and all that competed for them."""
