"""HTML for notebooks."""

from html import escape

_longest = 60  # rows of a table that are shown


def _cell(value):
    if isinstance(value, float):
        return f"{value:.5g}"
    return escape(str(value))


def table_html(columns, rows):
    head = "".join(f"<th>{escape(str(c))}</th>" for c in columns)
    body = "".join("<tr>" + "".join(f"<td>{_cell(v)}</td>" for v in row) + "</tr>" for row in rows[:_longest])
    more = f"<p>{len(rows) - _longest} more rows</p>" if len(rows) > _longest else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def fields_html(columns, count, row):
    """A table of a value with many elements, of which only those that are shown become rows: row(i)."""
    shown = min(count, _longest)
    more = f"<p>{count - shown} more rows</p>" if count > shown else ""
    return table_html(columns, [row(i) for i in range(shown)]) + more


def diagnostic_html(diagnostic):
    color = {"error": "#b00020", "warning": "#8a6d00"}.get(diagnostic.severity, "#555")
    # The hint of a node written in Python is a traceback with several lines.
    hint = f'<br><i style="white-space:pre-wrap">{escape(diagnostic.hint)}</i>' if diagnostic.hint else ""
    place = f"{diagnostic.file}:{diagnostic.line}" if diagnostic.line else diagnostic.file
    return (f'<p><b style="color:{color}">{escape(diagnostic.severity)} {escape(diagnostic.code)}</b> '
            f"{escape(place)} {escape(diagnostic.node)}: {escape(diagnostic.message)}{hint}</p>")


def graph_html(graph):
    from ._errors import Error
    try:
        return graph.draw("svg")
    except Error as error:
        return error._repr_html_()
