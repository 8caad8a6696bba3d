"""The simulations of a run over its iterations, drawn by plotly."""
