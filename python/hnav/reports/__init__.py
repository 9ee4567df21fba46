"""Scores of results, pictures by Matplotlib, and pages by Plotly."""
