"""What `./run study` makes of the rows of this study: tables, figures, pages and their checks. Not a part of mpmtools."""
