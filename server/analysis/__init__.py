"""`varil analyze`: from an export's zip to a folder with statistics, figures and a report."""
