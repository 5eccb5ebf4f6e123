"""The table of docs/stability.md: constructions down, methods across."""

from dataclasses import dataclass, field

from dapple.tests.stability.judge import METHODS, RUNGS

_HEAD = """# Stability

Constructions that are known to be awkward, one test each in `tests/stability/`, and what every method makes of them.
**Right**: every texel is within the tolerance (the mean squared error over the squared mean of the map, stricter than
over its mean square; how far one texel may be off, as a part of what is expected there). Points and all roots are as
exact as they are asked to be, here 1e-3: four times that and half of a texel's light are theirs on top. The first root
is judged by its mean over 8 x 8 points a texel.
*Reported*: not right, but every texel that is off carries a status that says why, or a sentence of the record
(`left_out`) does. **Wrong**: off, and silent. No cell may be.
Flat, sun map and caustic map make do with less, and are judged by how honest they are: *right* within 1e-2 of the mean
square, the tolerance of *Preview*; *reported* where their estimated error tells how far they are off, within a factor
of 4, or is 1 or more: of no use. A planner that goes by their estimates takes none that fails. The caustic map is that
of 128 points. Beams and points are `photon_splat`, the latter its check; the roots are `conic_walk`.

Unless a row says otherwise the water is the mesh as it is, without reconstruction. The last column says why the
expected answer is right.
Made from the tests' own results by `./dapple test tests/stability --stability-table docs/stability.md`.
"""


@dataclass
class Row:
    """One construction: name, case, why the answer is right, the test's id, the tolerance, method -> Verdict."""

    name: str
    case: str
    why: str
    node: str
    tolerance: str = ""
    cells: dict = field(default_factory=dict)

    def line(self, notes):
        """The row as Markdown; sentences of reported cells go into `notes`, and their number into the cell."""
        cells = [_cell(self.cells.get(method), notes) for method in (*METHODS, *RUNGS)]
        name = self.name.rstrip(".") + (f" ({self.case})" if self.case else "")
        why = self.why.replace("|", "&#124;")
        return f"| {name} | {' | '.join(cells)} | {self.tolerance} | {why} |"


def page(rows):
    """The whole page, Markdown."""
    rows = sorted(rows, key=lambda row: row.node.partition("::")[0])
    notes, lines = {}, []
    for row in rows:
        lines.append(row.line(notes))
    head = f"| construction | {' | '.join((*METHODS, *RUNGS))} | tolerance | expected, and why |"
    rule = "|---" * (len(METHODS) + len(RUNGS) + 3) + "|"
    told = [f"{number}. {text}" for text, number in notes.items()]
    return "\n".join([_HEAD, head, rule, *lines, "", "What is reported:", "", *told, ""])


def _cell(verdict, notes):
    """One cell, with a reference to what is reported."""
    if verdict is None:
        return "-"
    if verdict.outcome != "reported":
        return f"**{verdict.outcome}**" if verdict.outcome == "wrong" else verdict.outcome
    return f"*reported* [{notes.setdefault(verdict.why, len(notes) + 1)}]"
