"""Where squares lie in sheets, on shelves. Loads nothing: the panel counts sheets while it is drawn."""

_GAP = 4  # texels between neighbours: rounding lands light one texel past a border, at most


def count_sheets(sizes):
    """How many images of the largest size maps of these sizes are laid into."""
    return max((sheet for sheet, _, _ in shelved(sizes, max(sizes))), default=-1) + 1 if sizes else 0


def shelved(sizes, side):
    """(sheet, row, column) of squares of these sizes in as few square sheets as shelves make of them: the largest
    first, from left to right, each row as high as its first."""
    places, sheet, row, column, height = [None] * len(sizes), 0, 0, 0, 0
    for k in sorted(range(len(sizes)), key=lambda k: -sizes[k]):
        if column + sizes[k] > side:
            row, column, height = row + height + _GAP, 0, 0
        if row + sizes[k] > side:
            sheet, row, column, height = sheet + 1, 0, 0, 0
        places[k] = (sheet, row, column)
        column, height = column + sizes[k] + _GAP, max(height, sizes[k])
    return places
