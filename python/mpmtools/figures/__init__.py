"""Pictures of runs, the page of the study, and the style that all pages share."""
