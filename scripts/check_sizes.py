#!/usr/bin/env python3
"""Checks the size budgets: what does not fit a reader's head does not get in.

A file's lines, those of a command fewer; a function's lines, from the first of its signature to its closing brace; a function's cyclomatic
complexity (1 + branches), lambdas counted to the function around them. Exceptions, each with its reason, stand in
scripts/size_exceptions.txt.

Usage: check_sizes.py [--report] [ROOT]       --report also lists the twenty longest functions
"""
import dataclasses
import pathlib
import re
import sys

import sources

HEADER_LINES = 400
SOURCE_LINES = 800
FUNCTION_LINES = 80
FUNCTION_WARN_LINES = 60
FUNCTION_P95_LINES = 50
COMPLEXITY = 20
COMMAND_LINES = 80

# Files of apps/lumesh that are no command but what commands share, or whose command is not of a stage.
NO_COMMANDS = {
    "common.cpp": "checks and options of many commands",
    "option_adapter.cpp": "options of the library as those of the command line",
    "main.cpp": "main() and its exit codes",
    "progress.cpp": "the line that tells how far a command is",
    "completion.cpp": "words of shells, which no stage has",
}

# Spaces around && tell the operator from a reference to an rvalue: clang-format puts them there.
BRANCH = re.compile(r"\b(?:if|for|while|case|catch)\b| && | \|\| |\s\?\s")
CONTROL = re.compile(r"^(?:if|for|while|switch|do|else|try|catch|return)\b")


@dataclasses.dataclass
class Function:
    path: pathlib.Path
    name: str
    line: int
    lines: int
    complexity: int


def without_preprocessor(text):
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda match: "\n" * match.group().count("\n"), text, flags=re.MULTILINE)


def without_template_head(head):
    """`template <class T, int N> void f()` -> ` void f()`."""
    match = re.match(r"\s*template\s*<", head)
    if not match:
        return head
    depth, at = 1, match.end()
    while depth and at < len(head):
        depth += {"<": 1, ">": -1}.get(head[at], 0)
        at += 1
    return without_template_head(head[at:])


def kind_of_brace(head):
    """What an opening brace outside of functions begins, told from the text before it."""
    head = without_template_head(head).strip()
    if re.match(r"(?:inline\s+)?namespace\b|extern\s*\"", head):
        return "scope"
    if re.search(r"\)\s*(?:noexcept\s*)?:(?!:).*[\w>]$", head, re.DOTALL) and "->" not in head.split(":")[-1]:
        return "member"  # of a constructor's list: the body is yet to come
    if re.match(r"(?:typedef\s+)?(?:class|struct|union|enum)\b", head) and not head.endswith(")"):
        return "scope"
    if "(" in head and not re.search(r"[^=!<>]=\s*$|^\w[^()]*=[^=]", head) and not CONTROL.match(head):
        return "function"
    return "value"


def name_of(head):
    match = re.search(r"(operator\s*(?:\(\)|\[\]|[^\s\w(]+|\w+)|[\w:~]+)\s*\(", without_template_head(head))
    return match.group(1) if match else "?"


def matching_brace(text, at):
    """Where the block that opens at `at` closes."""
    depth = 0
    for match in re.compile(r"[{}]").finditer(text, at):
        depth += 1 if match.group() == "{" else -1
        if depth == 0:
            return match.start()
    return len(text) - 1


def functions_of(path, text):
    """All function definitions of a file whose comments are gone."""
    text = without_preprocessor(text)
    found, head_start, at = [], 0, 0
    for_stop = re.compile(r"[{};]")
    while match := for_stop.search(text, at):
        at = match.end()
        head = text[head_start:match.start()]
        access = re.match(r"\s*(?:(?:public|private|protected):\s*)+", head)
        if access:
            head_start += access.end()
            head = head[access.end():]
        if match.group() == ";" and head.count("(") > head.count(")"):
            continue
        if match.group() != "{":
            head_start = at
            continue
        kind = kind_of_brace(head)
        if kind == "scope":
            head_start = at
            continue
        at = matching_brace(text, match.start()) + 1
        if kind == "function":
            first = head_start + len(head) - len(head.lstrip())
            found.append(Function(path, name_of(head), text.count("\n", 0, first) + 1,
                                  text.count("\n", first, at) + 1, 1 + len(BRANCH.findall(text[match.start():at]))))
            head_start = at
    return found


def read_exceptions(root):
    """Lines of `PATH[:FUNCTION] REASON`."""
    path = root / "scripts/size_exceptions.txt"
    exceptions = {}
    for line in path.read_text().splitlines() if path.is_file() else []:
        if line.strip() and not line.startswith("#"):
            place, _, reason = line.partition(" ")
            if not reason.strip():
                raise SystemExit(f"{path}: {place} needs a reason")
            exceptions[place] = reason
    return exceptions


def faults_of_functions(functions):
    for function in functions:
        place = f"{function.path}:{function.line}: {function.name}"
        if function.lines > FUNCTION_LINES:
            yield f"{place} has {function.lines} lines, limit {FUNCTION_LINES}", function
        if function.complexity > COMPLEXITY and function.path.parts[0] != "tests":  # brute-force truths loop deeply
            yield f"{place} has complexity {function.complexity}, limit {COMPLEXITY}", function


def faults_of_commands(root, files):
    """Command files that do more than parse, call and print."""
    folder = pathlib.Path("apps/lumesh")
    for path in files:
        lines = (root / path).read_text().count("\n") if path.parent == folder and path.suffix == ".cpp" else 0
        if lines > COMMAND_LINES and path.name not in NO_COMMANDS:
            yield f"{path} has {lines} lines, limit {COMMAND_LINES} of a command: its work belongs to src/stages"


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else 0


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--report"]
    root = pathlib.Path(arguments[0]) if arguments else sources.ROOT
    exceptions, used, faults, functions = read_exceptions(root), set(), [], []
    files = sources.source_files(root, ["include", "internal", "src", "apps", "tests", "benchmarks", "examples"])
    for path in files:
        text = (root / path).read_text()
        limit = HEADER_LINES if path.parts[0] in ("include", "internal") else SOURCE_LINES
        if text.count("\n") > limit:
            used.add(str(path))
            if str(path) not in exceptions:
                faults.append(f"{path} has {text.count(chr(10))} lines, limit {limit}")
        functions += functions_of(path, sources.without_comments(text))
    for fault, function in faults_of_functions(functions):
        place = f"{function.path}:{function.name}"
        used.add(place)
        if place not in exceptions:
            faults.append(fault)
    faults += [*faults_of_commands(root, files), *sources.faults_of_nothing(files, root)]
    faults += [f"scripts/size_exceptions.txt: {place} needs no exception any more" for place in exceptions.keys() - used]
    own = [function for function in functions if function.path.parts[0] in ("include", "internal", "src", "apps")]
    p95 = percentile([f.lines for f in own if f"{f.path}:{f.name}" not in exceptions], 0.95)
    if p95 > FUNCTION_P95_LINES:
        faults.append(f"95 % of the functions should have at most {FUNCTION_P95_LINES} lines; it is {p95}")
    if "--report" in sys.argv:
        for function in sorted(own, key=lambda f: -f.lines)[:20]:
            print(f"{function.lines:4} lines, complexity {function.complexity:3}: {function.path}:{function.line} {function.name}")
    else:
        faults_or_warnings = [f"warning: {f.path}:{f.line}: {f.name} has {f.lines} lines, aim for {FUNCTION_WARN_LINES}"
                              for f in own if FUNCTION_WARN_LINES < f.lines <= FUNCTION_LINES]
        print("\n".join(faults_or_warnings), end="\n" if faults_or_warnings else "")
    print("\n".join(faults + [f"check_sizes: {len(files)} files, {len(own)} functions, median "
                              f"{percentile([f.lines for f in own], 0.5)} lines, 95 % {p95}, longest "
                              f"{max([f.lines for f in own], default=0)}; {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
