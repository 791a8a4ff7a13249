"""Numbers as the page prints them: with the digits that their uncertainty allows; a dash for what is not known."""

import math


UNKNOWN = "–"


def number(value, form):
    """By a format of Python."""
    return UNKNOWN if value is None or not math.isfinite(value) else format(value, form)


def percent(share, form=".0f"):
    return with_unit(number(100.0 * share, form), "%")


def short(value, scale=1.0):
    """Three significant digits."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    value *= scale
    digits = 2 - math.floor(math.log10(abs(value))) if value else 0
    return f"{value:.{min(digits, 4)}f}" if digits > 0 else f"{round(value, digits):.0f}"


def upward(value, scale=1.0):
    """Three significant digits, rounded up: a value to design with."""
    if not math.isfinite(value):
        return UNKNOWN
    value *= scale
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2) if value else 1.0
    return short(math.ceil(value / step - 1e-9) * step)


def downward(value, scale=1.0):
    """The same rounded down: the lower end of a range."""
    text = upward(-value, scale)
    return text if text == UNKNOWN or not float(text) else text[1:] if text[0] == "-" else f"-{text}"


def outward(low, high, scale=1.0):
    """Both ends of a range with their signs, three digits each, rounded away from its middle."""
    def signed(text, sign, other):
        return text if not float(text) else other + text[1:] if text[0] == "-" else sign + text

    return f"{signed(upward(-low, scale), '-', '+')} to {signed(upward(high, scale), '+', '-')}"


def value_and_error(value, uncertainty, scale=1.0):
    """Both with the digits that the uncertainty allows: two of its own, at most four of the value. Without one: three digits of the value."""
    if uncertainty is None or not math.isfinite(uncertainty) or not math.isfinite(value):
        return short(value, scale)
    value, uncertainty = value * scale, uncertainty * scale
    most = 3 - math.floor(math.log10(abs(value))) if value else 3
    digits = min(most, 1 - math.floor(math.log10(uncertainty)) if uncertainty > 0.0 else most)
    return " ± ".join(f"{round(number, digits):.{max(digits, 0)}f}" for number in (value, max(uncertainty, 10.0**-digits)))


def with_unit(text, unit):
    return f"{text} {unit}" if unit and text != UNKNOWN else text
