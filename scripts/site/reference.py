"""Pages of reference, made from what the programs and sources say of themselves."""
import ast
import json
import pathlib
import re


LINE = 80  # characters of a line of code that a page shows whole


def cell(text):
    """The text as a cell of a table."""
    return str(text).replace("|", "\\|").replace("\n", " ").replace("<", "&lt;")


def table(head, rows):
    if not rows:
        return ""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(cell, line)) + " |" for line in lines) + "\n\n"


def fenced(language, text):
    return f"```{language}\n{text.rstrip()}\n```\n\n"


# Commands, from commands.json of the program.

def option_name(option):
    if "short" in option:
        return f"`-{option['short']}`, `--{option['name']}`"
    return f"`--{option['name']}`"


def command_page(command):
    arguments = [(f"`{one['name']}`", f"`{one['value']}`", one["help"]) for one in command["arguments"]]
    options = [(option_name(one), f"`{one['value']}`" if one["value"] else "", one["help"]) for one in command["options"]]
    words = "".join(f" [{one['name']}{' ...' if one['many'] else ''}]" for one in command["arguments"])
    page = f"# tessera {command['name']}\n\n{command['about']}.\n\n" + fenced("sh", f"tessera {command['name']} [OPTIONS]{words}")
    page += "## Arguments\n\n" + table(("argument", "value", "meaning"), arguments) if arguments else ""
    page += "## Options\n\nA switch `--x` has an opposite, `--no-x`.\n\n" + table(("option", "value", "meaning"), options)
    # The blocks of the footer, as "Examples:", each with the lines below it.
    for block in re.split(r"\n(?=\S[^\n]*:\n)", command["footer"].strip()):
        title, colon, lines = block.partition(":\n")
        if colon and "\n" not in title:
            page += f"## {title}\n\n" + fenced("sh" if title == "Examples" else "text", re.sub(r"^  ", "", lines, flags=re.MULTILINE))
        elif block:
            page += block + "\n\n"
    return page


def command_pages(described):
    """(title, path, page) for each command."""
    return [(one["name"], f"reference/commands/{one['name']}.md", command_page(one)) for one in json.loads(described)]


def defaults_page(source):
    page = "# Defaults\n\nThe files with all defaults: of the command, and of the daemon.\n\n"
    for name in ("tessera", "tesserad"):
        page += f"## config/{name}.toml\n\n" + fenced("toml", (source / f"config/{name}.toml").read_text())
    return page


# HTTP, from the OpenAPI document and the processes of the daemon.

def type_of(schema):
    if "$ref" in schema:
        return schema["$ref"].rsplit("/", 1)[-1]
    if "enum" in schema:
        return ", ".join(map(str, schema["enum"]))
    kind = schema.get("type", "")
    return f"list of {type_of(schema['items'])}" if kind == "array" and "items" in schema else str(kind)


def route_section(path, method, route):
    text = f"### {method.upper()} `{path}`\n\n{route['summary']}. Role: {route['x-role']}.\n\n"
    rows = [(f"`{one['name']}`", one["in"], type_of(one.get("schema", {})), one.get("description", "")) for one in route.get("parameters", []) if "name" in one]
    return text + table(("parameter", "in", "type", "meaning"), rows)


def process_section(process):
    rows = [(f"`{name}`", type_of(one.get("schema", {})), "yes" if one.get("minOccurs", 1) > 0 else "", one.get("description") or one.get("title", ""))
            for name, one in process["inputs"].items()]
    return f"### {process['id']}\n\n{process.get('description') or process.get('title', '')}\n\n" + table(("input", "type", "needed", "meaning"), rows)


def http_page(api, processes):
    page = ("# HTTP\n\nThe routes of the daemon, as its OpenAPI document `/v1/api` describes them. [service.md](../docs/service.md) shows how to use "
            "them.\n\n## Routes\n\n")
    for path, routes in api["paths"].items():
        page += "".join(route_section(path, method, route) for method, route in routes.items())
    return page + "## Processes\n\nThe kinds of jobs, with their inputs.\n\n" + "".join(map(process_section, processes))


# Python, from the sources of the package.

def signature_of(function):
    returns = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    text = f"{function.name}({ast.unparse(function.args)}){returns}"
    # Parameters begin lines where a line is not enough. A comma in brackets separates no parameters.
    return text if len(text) <= LINE else re.sub(r", (?=\*|\w+(?::|=|,|\)))", ",\n    ", text)


def docstring_page(docstring):
    """A docstring of NumPy's style as Markdown: headings in bold, a list of what is named in a section."""
    if not docstring:
        return ""
    text = re.sub(r"^(\w[\w ]*)\n-{3,}$", r"**\1**\n", docstring, flags=re.MULTILINE)
    given = text.split("\n")
    lines, is_list = [], False
    for place, line in enumerate(given):
        follows = given[place + 1] if place + 1 < len(given) else ""
        if re.match(r"\w", line) and re.match(r"    \w", follows):
            is_list = True
            lines += ["", f"- `{line}`:"]  # the name of a parameter; what it means is indented below
        elif is_list and line.startswith("    "):
            lines += [line]
        else:
            is_list = is_list and not line
            lines += [line]
    return "\n".join(lines) + "\n\n"


def python_class(node):
    page = f"## {node.name}\n\n" + docstring_page(ast.get_docstring(node))
    for place, member in enumerate(node.body):
        if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
            page += fenced("python", signature_of(member)) + docstring_page(ast.get_docstring(member))
        elif isinstance(member, ast.AnnAssign) and isinstance(member.target, ast.Name) and not member.target.id.startswith("_"):
            page += fenced("python", f"{member.target.id}: {ast.unparse(member.annotation)}")
            follows = node.body[place + 1] if place + 1 < len(node.body) else None
            if isinstance(follows, ast.Expr) and isinstance(follows.value, ast.Constant) and isinstance(follows.value.value, str):
                page += follows.value.value + "\n\n"
    return page


def python_page(package):
    """All that the package exports, in the order of __all__."""
    init = ast.parse((package / "__init__.py").read_text())
    public = ast.parse((package / "_public.py").read_text())
    exported = next(ast.literal_eval(node.value) for node in public.body
                    if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__")
    found = {}
    for path in sorted(package.glob("*.py")):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ClassDef):
                found[node.name] = python_class(node)
            elif isinstance(node, ast.FunctionDef):
                found[node.name] = f"## {node.name}\n\n" + fenced("python", signature_of(node)) + docstring_page(ast.get_docstring(node))
    missing = [name for name in exported if name not in found]
    if missing:
        raise SystemExit(f"make_site: {package} exports {', '.join(missing)}, which no source defines")
    page = "# Python\n\n" + docstring_page(ast.get_docstring(init)) + "[python.md](../docs/python.md) is the guide.\n\n"
    return page + "".join(found[name] for name in exported)


# C++, from the public headers.

def header_page(path):
    text = path.read_text()
    about = re.match(r"((?://[^\n]*\n)+)", text)[1]
    about = re.sub(r"^// ?", "", about, flags=re.MULTILINE)
    code = text[text.index("#pragma once"):].removeprefix("#pragma once").strip()
    return f"# tessera/{path.name}\n\n{about}\n" + fenced("cpp", f'#include "tessera/{path.name}"') + fenced("cpp", code)


def header_pages(folder):
    """(title, path, page) for each public header."""
    return [(path.name, f"reference/cpp/{path.stem}.md", header_page(path)) for path in sorted(pathlib.Path(folder).glob("*.h"))]
