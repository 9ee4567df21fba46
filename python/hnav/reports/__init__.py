"""What results are worth and how they are shown: scores, pictures by Matplotlib, the page about a simulation by Plotly."""
