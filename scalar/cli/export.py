"""``scalar export``: write a calibration in the formats that other software reads."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.group import cli
from scalar.cli.options import EFFECTS_MODULE, PATH, load_effects
from scalar.cli.outputs import FORCE, refuse_foreign, text_with
from scalar.cli.terminal import say
from scalar.errors import Fault, InvalidInput
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.effects import Effect
    from scalar.estimation.result import Calibration
    from scalar.export.rigid_part import RigidPart

_FORMS = {
    ".urdf": "a URDF",
    ".yaml": "UR's kinematics.yaml",
    ".csv": "a DH table",
    ".md": "a DH table in Markdown",
}
_WRITES = {
    ".urdf": "Joint origins by scalar",
    ".yaml": "# Written by `scalar export`",
    ".csv": "beta_nominal_rad,",
    ".md": "with Hayati's beta",
}
"""What stands at the beginning of a file that this command wrote, so that it may be replaced without --force."""
_OF_JOINTS = ("approach", "tau", "payload")  # how the names of columns begin that effects of joints need


@cli.command()
@click.argument("calibration", type=PATH)
@click.option("-o", "--output", type=PATH, required=True, help="File to write: .urdf, .yaml, .csv or .md.")
@click.option("--urdf", type=PATH, help="URDF of the nominal arm, for a .urdf.")
@click.option("--base", metavar="LINK", help="With --urdf: the link of the base; the root if not given.")
@click.option(
    "--tip", metavar="LINK", help="With --urdf: the link of the flange; the only last link if not given."
)
@click.option(
    "--sensor-link",
    metavar="LINK",
    help="With --urdf: the link of the sensor, which is added if missing; scalar_sensor if not given.",
)
@click.option("--ur-hash", metavar="calib_N", help="The controller's checksum, for a .yaml.")
@click.option(
    "--convention",
    type=click.Choice(["standard-dh", "modified-dh"]),
    help="Convention of a DH table; that of dataset.yaml if not given.",
)
@click.option(
    "--at",
    "at",
    metavar="COLUMN=NUMBER",
    multiple=True,
    help="Value of a column that an effect needs, as in temperature=35; may be given again.",
)
@FORCE
@EFFECTS_MODULE
def export(
    calibration: Path,
    output: Path,
    urdf: Path | None,
    base: str | None,
    tip: str | None,
    sensor_link: str | None,
    ur_hash: str | None,
    convention: str | None,
    at: Sequence[str],
    force: bool,
    effects_modules: Sequence[Path],
) -> None:
    """Write a calibration for other software.

    \b
    The name of the output says what is written:
      .urdf  the description given as --urdf, with the calibrated geometry and a link for the sensor
      .yaml  kinematics.yaml of the ROS packages of Universal Robots (a UR arm in the frames base and tool0)
      .csv   DH parameters, one row for each joint [m, rad], standard or modified as in dataset.yaml (see --convention)
      .md    the same as text to be read, in Markdown [mm, deg], with the transforms of base, flange and sensor

    None of these holds effects that change from pose to pose. They are listed with the distance by which they
    move the sensor at 1000 random poses within the joint limits; `scalar correct` applies them.

    There is no form for controllers of KUKA or ABB: no public source was found that documents a parameter file of theirs which holds a
    whole calibration. (KUKA's handbook of $MACHINE.DAT documents $DH_4 and $DH_5, for the frames of the wrist.) For these arms,
    correct the joint angles of the program: `scalar correct`.

    \b
    Example:
      scalar export out/calibration.json --urdf robot.urdf --base base_link --tip tool0 -o calibrated.urdf
    """
    from scalar.cli.pose_lines import lines_on_doubts
    from scalar.data.io.atomic import atomic_write
    from scalar.estimation.result import load_calibration
    from scalar.export.rigid_part import rigid_part

    form = output.suffix.lower()
    _check_options(output, form, urdf, bool(base or tip or sensor_link), convention)
    refuse_foreign([(output, text_with(_WRITES[form]))], force, [calibration, *([urdf] if urdf else [])])
    load_effects(effects_modules)
    model = load_calibration(calibration)
    rigid = rigid_part(model.model, _columns(at, model.model.effects))
    if urdf is not None:
        content, note = _urdf(model, rigid, urdf, base, tip, sensor_link, calibration.name)
    elif form == ".yaml":
        content, note = _ur_kinematics(model, rigid, ur_hash, str(calibration))
    else:
        content, note = _dh_table(model, rigid, form, convention)
    with atomic_write(output) as temporary:
        temporary.write_text(content, encoding="utf-8", newline="\n")
    for line in _included_and_left_out(rigid, _FORMS[form]):
        say(line)
    if note:
        say(f"  {note}")
    for line in (*_not_determined(model), *lines_on_doubts(model)):
        say(line)
    if form == ".csv":
        same = f" --convention {convention}" if convention else ""
        say(f"  the transforms of base, flange and sensor are in the table in Markdown: -o NAME.md{same}")
    say(f"written: {output}")


def _not_determined(calibration: Calibration) -> list[str]:
    """Return lines on the frames of the file that the calibration does not determine: that of the flange on the arm, and that of the base."""
    from scalar.cli.correct_words import unknown_of_flange
    from scalar.estimation.fixed_parameter import BASE_NOT_SHOWN

    lines = [
        f"  the frame of the sensor is calibrated; {of_flange}, so the frame of the flange, and another tool on it, may be off by a constant "
        "that the sensor's frame does not have"
        for of_flange in unknown_of_flange(calibration.gauge, calibration.model.nominal)
    ]
    if any(entry.get("reason") == BASE_NOT_SHOWN for entry in calibration.gauge):
        lines.append(
            "  where the base stands is not determined by these data: frames are right relative to one another, so compare them with "
            "measurements after the best fit of the base"
        )
    return lines


def _check_options(
    output: Path, form: str, urdf: Path | None, for_urdf: bool, convention: str | None
) -> None:
    """Refuse options that do not go with the form of the output.

    Args:
        output: File to write.
        form: The end of its name.
        urdf: URDF of the nominal arm, or None.
        for_urdf: Whether another option that belongs to a URDF is given.
        convention: Of a DH table, or None.

    Raises:
        InvalidInput: They do not, or the form is unknown.
    """
    if form not in _FORMS:
        known = ", ".join(f"{suffix} ({what})" for suffix, what in _FORMS.items())
        raise InvalidInput(Fault(str(output), f"the end of the name says what to write: {known}"))
    if form == ".urdf" and urdf is None:
        message = "a URDF is made from that of the nominal arm; give it as --urdf, or write a DH table: -o parameters.csv"
        raise InvalidInput(Fault(str(output), message))
    if form != ".urdf" and (urdf or for_urdf):
        message = "--urdf, --base, --tip and --sensor-link are for a .urdf; leave them out, or write a .urdf"
        raise InvalidInput(Fault(str(output), message))
    if convention and form not in (".csv", ".md"):
        raise InvalidInput(Fault("--convention", "is for a .csv or .md; leave it out, or write one of these"))


def _urdf(
    calibration: Calibration,
    rigid: RigidPart,
    urdf: Path,
    base: str | None,
    tip: str | None,
    sensor_link: str | None,
    source: str,
) -> tuple[str, str]:
    """Return the URDF of the calibrated arm, and a line on the link of the sensor; ``source`` is the name of the calibration's file."""
    from scalar.export.urdf import SENSOR_LINK, put_calibration, text_of
    from scalar.ingest.urdf import read_urdf

    document = read_urdf(urdf)
    nominal = calibration.model.nominal
    sensor = put_calibration(document, base, tip, nominal, rigid, sensor_link or SENSOR_LINK)
    return text_of(document, source), sensor


def _ur_kinematics(
    calibration: Calibration, rigid: RigidPart, ur_hash: str | None, source: str
) -> tuple[str, str]:
    """Return UR's kinematics.yaml, and a line if it lacks the controller's checksum; ``source`` is the path of the calibration."""
    from scalar.export.ur_kinematics import NO_HASH, ur_kinematics

    lacking = ""
    if ur_hash is None:
        lacking = (
            f"the file has 'hash: {NO_HASH}', because --ur-hash is not given: the driver compares it with the controller's checksum, and will "
            "report that they differ"
        )
    return ur_kinematics(calibration.model.nominal, rigid, ur_hash, source), lacking


def _dh_table(
    calibration: Calibration, rigid: RigidPart, form: str, convention: str | None
) -> tuple[str, str]:
    """Return the DH table, and a line on what its convention cannot express; the convention is that of dataset.yaml if None is given."""
    from scalar.export.dh_table import beyond_standard_dh, dh_csv, dh_markdown

    standard = calibration.model.nominal.standard_dh if convention is None else convention == "standard-dh"
    content = (dh_csv if form == ".csv" else dh_markdown)(calibration, rigid, standard=standard)
    return content, beyond_standard_dh(rigid.robot) if standard else ""


def _columns(at: Sequence[str], effects: Sequence[Effect]) -> dict[str, float]:
    """Return the numbers of ``--at`` by column; columns that no effect follows are refused."""
    found: dict[str, float] = {}
    for text in at:
        name, equals, number = text.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            equals = ""
        if not equals or not math.isfinite(found[name.strip()]):
            raise InvalidInput(Fault("--at", f"{text!r} is not a column and a number; write temperature=35"))
    known = sorted({name for effect in effects for name in (*effect.follows, *effect.depends_on)})
    for name in found:
        if name not in (*known, "order", "time") and not name.startswith(_OF_JOINTS):
            which = f"they follow {' and '.join(known)}" if known else "they follow no column"
            raise InvalidInput(Fault("--at", f"no effect of this calibration follows {name!r}; {which}"))
    return found


def _included_and_left_out(rigid: RigidPart, form: str) -> list[str]:
    """Return lines that name the effects in the file and those that it cannot hold, with the size of these."""
    lines = [f"  included in the geometry: {effect.title}" for effect in rigid.included]
    if not rigid.left_out:
        but_for = " but for the place of the sensor" if form == _FORMS[".csv"] else ""
        return [*lines, f"  {form} holds the whole calibration{but_for}"]
    for left_out in rigid.left_out:
        if left_out.rms is None or left_out.largest is None:
            size = f"not sized: give --at {left_out.missing}=NUMBER"
        else:
            size = f"{left_out.rms / MM:.4f} mm RMS, at most {left_out.largest / MM:.4f} mm, at 1000 random poses"
        lines.append(f"  {form} cannot hold: {left_out.effect.title}, {size}")
    known = [left_out for left_out in rigid.left_out if left_out.rms is not None]
    if len(known) > 1:
        lines.append(
            f"  together: {rigid.rms / MM:.4f} mm RMS, at most {rigid.largest / MM:.4f} mm, at 1000 random poses"
        )
    return [
        *lines,
        "  `scalar predict` and `scalar correct` apply what this file leaves out; for a controller that takes only such a file, "
        "a calibration without effects (before.json of a diagnosis) may err less",
    ]
