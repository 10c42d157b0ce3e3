"""The generated sections of docs/results.md: everything between `<!-- bench:NAME -->` and `<!-- /bench:NAME -->`."""

import pathlib
import re

from suite.tables import TABLES

ROOT = pathlib.Path(__file__).resolve().parents[2]

CAPTIONS = {
    "refine": "Errors of the views against the exact ones, before and after refining. *published*: central differences, the "
              "two-step correction of the normals and Cholesky factorisation, after Nehab et al. 2005, in this program "
              "(`--stencil paper --bias two-step --solver cholesky --robust-rounds 0 --lambda L`); *best*: of the lambdas "
              "0.001, 0.01, 0.03, 0.1, 0.3 the one of least depth error, which takes the truth to know.",
    "fit": "Real normal maps without a known truth: median angle between the normals of the geometry (central differences) and the "
           "measured normals, and those normals that the method corrected.",
    "align": "Mean displacement of the views' own samples from their true place. All start from the same poses. ICP of two clouds "
             "at a time is chained along the tree of greatest overlaps.",
    "merge": "One mesh from the same views: refined by relief, at their true poses (bunny: the scans, at the published poses). "
             "*accuracy*: from result to truth; *completeness*: from truth to result; *within 0.5*: part of the true area that has "
             "the result within half a spacing; *normals*: mean angle, over the true area.",
    "chain": "From scans as measured, at their starting poses, to the model.",
    "real": "{machine}; {programs}. Real sets through `relief run` with its defaults. *given*, *off* (4°, 2 mm), *none* (and shuffled): the "
            "poses that a method starts from. *own*: median distance of samples from the planes of their partners in all overlapping pairs at "
            "these poses, by `bench/peers/pair_residuals.py`; *common*: the same of all samples that have a partner at the published "
            "poses (without such, at those of the method that placed most views), whether they still have one or not. Lengths in sample spacings.",
    "hard": "{machine}; {programs}. 16 views with one defect of real scans each (8 in the quick case) through `relief run` with its defaults. *depth*: RMS of "
            "the refined views, *before*: of the scans; *model*: RMS of what was measured, and *back* from all of the truth; *x clean*: "
            "against the same views without the defect; *bound*: what the defect leaves to be known, likewise: the same program on "
            "as much white noise, with fewer samples, or what rigid motions and averages leave of a systematic error, and in the depth those motions themselves (`bench/suite/stages/hard.py`).",
    "sixteen": "Sixteen views, range noise of 0.3 spacings, normals of 1.5 deg noise and 4 deg smooth bias: aligned, refined, aligned again, "
               "merged and polished with the defaults, at the poses found and at the true ones. *measured*: from the measured vertices' "
               "part of the model to the truth, RMS and mean angle of normals; *completeness* and *normals back*: from all of the truth.",
}
MEASURED = ("Measured on {machine}; {programs}. Lengths are in sample spacings, angles in degrees. *time* is the wall-clock time "
            "of the whole process with reading, computing and writing, for Open3D with the 1 s that its Python module takes to load; "
            "*processor time* is relative to relief on the same case in the same run; *memory* is the peak. Methods "
            "of under 5 s are run three times in turns, the least counts.")


def section(text, name, content):
    """`text` with the section `name` replaced."""
    pattern = re.compile(rf"(<!-- bench:{name} -->\n).*?(<!-- /bench:{name} -->)", re.DOTALL)
    if not pattern.search(text):
        raise ValueError(f"the document has no section <!-- bench:{name} -->")
    return pattern.sub(lambda found: found.group(1) + content.strip() + "\n" + found.group(2), text)


def shortened(command, case):
    """A command line as a reader would type it: programs without their folder, files below the case's folder."""
    words = []
    for word in command.split(" "):
        word = word.replace(str(ROOT) + "/", "")
        word = re.sub(rf"^\S*/{case}/(?=.)", "", word)
        words.append(word.rsplit("/", 1)[-1] if "/data/" in word or word.endswith("/apps/relief") else word)
    return " ".join(words)


def command_lines(rows):
    """The commands behind the rows of the first case; of methods that take pairs of views only the first pair's."""
    case = rows[0]["case"]
    lines = []
    for line in rows:
        commands = line.get("cost", {}).get("commands", [])
        if line["case"] != case or line.get("hidden") or not commands:
            continue
        alike = len({command.split(" ")[0] for command in commands}) == 1 and len(commands) > 2
        shown = commands[:1] if alike else commands
        lines += [shortened(command, case) + ("    # and so each pair" if alike else "") for command in shown]
    return "```\n" + "\n".join(lines) + "\n```"


def sections(results):
    """name -> Markdown, of everything that was measured."""
    cases = "\n".join(f"- *{name}*: {case['title']}; sample spacing {case['spacing']:.3g} {case['unit']}"
                      for name, case in results["cases"].items())
    content = {"machine": f"{MEASURED.format(**results)}\n\n{cases}"}
    for stage, render in TABLES.items():
        rows = [line for line in results["rows"] if line["stage"] == stage]
        content[stage] = "Not measured yet."
        if rows:
            caption = CAPTIONS[stage].replace("{machine}", results["machine"]).replace("{programs}", results["programs"])
            content[stage] = f"{caption}\n\n{render(rows)}\n\nCommands (*{rows[0]['case']}*):\n\n{command_lines(rows)}"
    return content


def update(path, results, with_machine=True):
    """Replaces the sections of all stages that were measured. `with_machine`: also the list of machine and cases."""
    text = path.read_text(encoding="utf-8")
    measured = {line["stage"] for line in results["rows"]} | ({"machine"} if with_machine else set())
    for name, content in sections(results).items():
        if name in measured:
            text = section(text, name, content)
    path.write_text(text, encoding="utf-8")


def plain(results):
    return "\n\n".join(f"## {name}\n\n{content}" for name, content in sections(results).items()) + "\n"
