"""Random NGC programs for fuzz_rs274.py: each is made from a number, the same every time."""

import random

OPERATORS = ["+", "-", "*", "/", "**", "MOD", "EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "XOR"]
FUNCTIONS = ["ABS", "ACOS", "ASIN", "COS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN"]


class Maker:
    """One program, line by line. Places are kept small, so that moves stay within every machine."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.lines, self.label, self.parameters, self.names = [], 100, [], []
        self.inverse, self.depth = False, 0

    # --- numbers ---

    def literal(self, low=-50.0, high=50.0):
        value = self.random.uniform(low, high)
        form = self.random.random()
        if form < 0.4:
            return str(round(value))
        if form < 0.9:
            return f"{value:.{self.random.randint(1, 4)}f}"
        text = f"{abs(value) % 1:.3f}".lstrip("0")
        return ("-" if value < 0 else "") + text

    def expression(self, depth=0):
        """In brackets; near zero, whatever it holds."""
        if depth > 2 or self.random.random() < 0.3:
            return self.operand()
        kind = self.random.random()
        if kind < 0.7:
            left, right = self.expression(depth + 1), self.expression(depth + 1)
            return f"[{left} {self.random.choice(OPERATORS)} {right}]"
        if kind < 0.8:
            return f"ATAN[{self.expression(depth + 1)}]/[{self.expression(depth + 1)}]"
        return f"{self.random.choice(FUNCTIONS)}[{self.expression(depth + 1)}]"

    def operand(self):
        kind = self.random.random()
        if self.parameters and kind < 0.25:
            return f"#{self.random.choice(self.parameters)}"
        if self.names and kind < 0.35:
            return f"#<{self.random.choice(self.names)}>"
        if kind < 0.4:
            return self.random.choice(["#5420", "#5421", "#5422", "#<_x>", "#<_y>", "#<_z>", "#5220", "#5210"])
        return self.literal(-9, 9)

    def number(self, low=-50.0, high=50.0):
        kind = self.random.random()
        if kind < 0.75:
            return self.literal(low, high)
        middle, half = (low + high) / 2, (high - low) / 2
        if kind < 0.85 and self.parameters and low < 0 < high:
            return f"[#{self.random.choice(self.parameters)} MOD {half:.0f}]"
        return f"[{middle:.3f} + [{self.expression()}] MOD {max(half, 0.001):.3f} / 2]"

    def axes(self, letters="XYZ", low=-50.0, high=50.0, least=1):
        chosen = [letter for letter in letters if self.random.random() < 0.55]
        while len(chosen) < least:
            chosen = sorted({*chosen, self.random.choice(letters)})
        return " ".join(f"{letter}{self.number(low, high)}" for letter in chosen)

    # --- lines ---

    def add(self, text):
        if self.random.random() < 0.06:
            text = f"N{self.random.randint(1, 9999)} {text}"
        if self.random.random() < 0.05:
            text = text.lower() if "(" not in text else text
        if self.random.random() < 0.05:
            text += self.random.choice([" (a remark)", " ; a remark", "(x)"])
        self.lines.append(text)

    def feed_word(self):
        if self.inverse:
            return f" F{self.random.uniform(0.2, 30):.2f}"
        return f" F{self.random.randint(10, 3000)}" if self.random.random() < 0.3 else ""

    def move(self):
        code = self.random.choice(["G0 ", "G1 ", "G1 ", "", "G0", "G1"])
        if code == "" and self.random.random() < 0.5:
            code = "G1 "
        feed = self.feed_word() if code != "G0 " else ""
        # With G93 each G1 wants F, and a line without a code may be one.
        self.add(f"{code}{self.axes()}{feed}")

    def modal(self):
        codes = [
            self.random.choice(["G90", "G91"]), self.random.choice(["G17", "G18", "G19"]), self.random.choice(["G20", "G21", "G21"]),
            self.random.choice(["G90.1", "G91.1"]), self.random.choice(["G54", "G55", "G56", "G59", "G59.1", "G59.3"]),
            self.random.choice(["G61", "G61.1", "G64", "G64 P0.1"]), self.random.choice(["G98", "G99"]), "G49", "G40", "G80",
        ]
        chosen = self.random.sample(codes, self.random.choice([1, 1, 1, 2, 3]))
        # An F of an inch line is read before or after G20: see order_units_first of rs274.known.
        line = " ".join(chosen)
        if self.random.random() < 0.25 and not self.inverse and "G80" not in chosen:
            line += " G0 " + self.axes()
        self.add(line)

    def offsets(self):
        kind = self.random.randrange(9)
        if kind == 0:
            turn = self.random.choice(["", "", f" R{self.random.choice(['0', '30', '90', '-45.5', '180'])}"])
            self.add(f"G10 L2 P{self.random.randint(0, 9)} {self.axes()}{turn}")
        elif kind == 1:
            self.add(f"G10 L20 P{self.random.randint(0, 9)} {self.axes()}")
        elif kind == 2:
            self.add(f"G92 {self.axes()}")
        elif kind == 3:
            self.add(self.random.choice(["G92.1", "G92.2", "G92.3"]))
        elif kind == 4:
            self.add(f"G43.1 {self.axes(low=-20, high=20)}")
        elif kind == 5:
            self.add("G49")
        elif kind == 6:
            self.add(self.random.choice(["G43 H1", "G43 H2", f"G10 L1 P1 Z{self.literal(-20, 20)}", "G43 H3", "G43.2 H3"]))
        elif kind == 7:
            self.add(f"G53 G{self.random.choice('01')} {self.axes()}" + self.feed_word())
        else:
            self.add(self.random.choice(["G28.1", f"G28 {self.axes('XY')}"]))

    def arc(self):
        """From a known place, so that both ends lie on the circle."""
        plane = self.random.choice(["G17", "G18", "G19"])
        first, second, third = {"G17": "XYZ", "G18": "XZY", "G19": "YZX"}[plane]
        i, j = {"X": "I", "Y": "J", "Z": "K"}[first], {"X": "I", "Y": "J", "Z": "K"}[second]
        half_x, half_y = self.random.randint(-9, 9) or 3, self.random.randint(-9, 9) or 4
        sense, turns = self.random.choice(["G2", "G3"]), self.random.choice(["", "", "", " P2", " P1", " P3"])
        along = f" {third}{self.literal(-9, 9)}" if self.random.random() < 0.4 else ""
        feed = self.feed_word()
        kind = self.random.random()
        if kind < 0.4:
            # Centre on any of the points as far from both ends: half the chord, and a stretch across it.
            aside = self.random.randint(-3, 3)
            x, y = half_x - aside * half_y, half_y + aside * half_x
            self.add(f"{plane} G91 G91.1")
            self.add(f"{sense} {first}{2 * half_x} {second}{2 * half_y}{along} {i}{x} {j}{y}{turns}{feed}")
        elif kind < 0.6:
            radius = (half_x ** 2 + half_y ** 2) ** 0.5 + self.random.choice([0.001, 1, 5])
            sign = self.random.choice(["", "-"])
            self.add(f"{plane} G91")
            self.add(f"{sense} {first}{2 * half_x} {second}{2 * half_y}{along} R{sign}{radius:.4f}{turns}{feed}")
        elif kind < 0.8:
            self.add(f"{plane} G90 G91.1 G0 {first}1 {second}2")
            self.add(f"{sense} {first}{1 + 2 * half_x} {second}{2 + 2 * half_y}{along} {i}{half_x} {j}{half_y}{turns}{feed}")
        else:
            self.add(f"{plane} G90 G90.1 G0 {first}1 {second}2")
            self.add(f"{sense} {first}{1 + 2 * half_x} {second}{2 + 2 * half_y}{along} {i}{1 + half_x} {j}{2 + half_y}{turns}{feed}")
            self.add("G91.1")
        if self.random.random() < 0.15:
            self.add(f"{plane} G91.1 {sense} {i}{half_x} {j}{half_y}{turns}{feed}")

    def cycle(self):
        if self.inverse:
            return
        out = self.random.choice(["G98", "G99", "G99"])
        # G88 wants an operator, and rs274 refuses L of G74.
        code = self.random.choice(["G81", "G82", "G83", "G73", "G85", "G89", "G84", "G74", "G86"])
        more = {"G82": " P0.2", "G89": " P0.1", "G83": " Q1.5", "G73": " Q2.25", "G86": " P0.3"}.get(code, "")
        if code in ("G84", "G74"):
            more = self.random.choice(["", " P0.4"])
        repeat = f" L{self.random.randint(1, 3)}" if code != "G74" and self.random.random() < 0.25 else ""
        if code in ("G84", "G74", "G86") and self.random.random() < 0.9:
            self.add({"G84": "M3", "G74": "M4"}.get(code, self.random.choice(["M3", "M4"])) + self.random.choice([" S100", ""]))
        if self.random.random() < 0.6:
            self.add("G90 G17")
            self.add(f"G0 Z{self.random.randint(6, 20)}")
            words = f"Z-{self.literal(1, 9)} R{self.random.choice(['2', '1.5', '0.2'])}"
        else:
            self.add("G91 G17")
            words = f"Z-{self.literal(2, 9)} R{self.random.choice(['-1', '0.5', '-2.5'])}"
        self.add(f"{out} {code} {self.axes('XY')} {words}{more}{repeat} F{self.random.randint(50, 900)}")
        for _ in range(self.random.randint(0, 2)):
            self.add(self.axes("XY"))
        self.add("G80")

    def parameter(self):
        if self.random.random() < 0.6:
            which = self.random.randint(1, 60)
            target = f"#{which}"
            after = lambda: self.parameters.append(which)
        else:
            name = self.random.choice(["a", "depth", "_global", "Long Name", "x2"])
            target = f"#<{name}>"
            after = lambda: self.names.append(name)
        line = f"{target} = {self.random.choice([self.literal(-9, 9), f'[{self.expression()}]'])}"
        if self.random.random() < 0.2:
            line += f" #{self.random.randint(1, 60)} = {self.literal()}"
        if self.random.random() < 0.15 and not self.inverse:
            line += f" G0 X{self.number()}"
        self.add(line)
        after()

    def new_label(self):
        self.label += 1
        return f"o{self.label}" if self.random.random() < 0.7 else f"o<loop{self.label}>"

    def flow(self):
        if self.depth >= 2:
            return self.move()
        self.depth += 1
        label, kind = self.new_label(), self.random.randrange(5)
        counter = 70 + self.label % 30
        if kind == 0:
            self.lines.append(f"{label} if [{self.expression()}]")
            self.body()
            for _ in range(self.random.choice([0, 0, 1, 2])):
                self.lines.append(f"{label} elseif [{self.expression()}]")
                self.body()
            if self.random.random() < 0.5:
                self.lines.append(f"{label} else")
                self.body()
            self.lines.append(f"{label} endif")
        elif kind == 1:
            self.lines += [f"#{counter} = 0", f"{label} while [#{counter} LT {self.random.randint(0, 4)}]", f"#{counter} = [#{counter} + 1]"]
            self.leave(label)
            self.body()
            self.lines.append(f"{label} endwhile")
        elif kind == 2:
            self.lines += [f"#{counter} = 0", f"{label} do", f"#{counter} = [#{counter} + 1]"]
            self.leave(label)
            self.body()
            self.lines.append(f"{label} while [#{counter} LT {self.random.randint(0, 4)}]")
        elif kind == 3:
            self.lines.append(f"{label} repeat [{self.random.randint(0, 4)}]")
            self.leave(label)
            self.body()
            self.lines.append(f"{label} endrepeat")
        elif self.depth == 1:
            self.sub(label)
        self.depth -= 1

    def leave(self, label):
        if self.random.random() < 0.25:
            inner = self.new_label()
            self.lines += [f"{inner} if [{self.expression()}]", f"{label} {self.random.choice(['break', 'continue'])}", f"{inner} endif"]

    def sub(self, label):
        self.lines.append(f"{label} sub")
        self.lines.append("G1 X#1 Y[#2 MOD 40] F200" if not self.inverse else "G0 X#1 Y[#2 MOD 40]")
        self.body()
        if self.random.random() < 0.3:
            inner = self.new_label()
            self.lines += [f"{inner} if [#1 GT #2]", f"{label} return [{self.expression()}]", f"{inner} endif"]
        self.lines.append(f"{label} endsub" + (f" [{self.expression()}]" if self.random.random() < 0.4 else ""))
        for _ in range(self.random.randint(1, 2)):
            self.lines.append(f"{label} call" + "".join(f" [{self.expression()}]" for _ in range(self.random.randint(1, 4))))
        if self.random.random() < 0.4:
            self.lines.append("G0 X[#<_value> MOD 40]")

    def body(self):
        for _ in range(self.random.randint(1, 3)):
            self.line()

    def spline(self):
        self.add("G17 G91")
        words = " ".join(f"{letter}{self.literal(-5, 5)}" for letter in ("XYIJPQ"))
        self.add(f"G5 {words} F300" if not self.inverse else "G0 X1")
        # Where the spline ended, by what comes next; somewhere else, so that it is a move.
        self.add(f"G91 G0 X{self.literal(1, 9)} Y{self.literal(-9, -1)} Z1")

    def other(self):
        kind = self.random.randrange(9)
        if kind == 0:
            self.add(f"G4 P{self.random.choice(['0.5', '1', '0', self.number(0.1, 2)])}")
        elif kind == 1:
            self.inverse = not self.inverse
            # G1 and its F at once: a modal motion of before would want one.
            self.add("G93 G0 X1" if self.inverse else f"G94 G0 X1 F{self.random.randint(50, 800)}")
        elif kind == 2:
            self.add(self.random.choice(["(MSG, hello there)", "(a remark)", "(DEBUG, #1 and #<_x>)", "; nothing", "", "/ G0 X3", "/G1 Y2 F99", "(MSG,)"]))
        elif kind == 3:
            self.add(self.random.choice(["M0", "M1", "M60", "M9", "M3 S100", "M5", "T1 M6", "T2", "M6 T2", "S500", "F250"]))
        elif kind == 4:
            self.spline()
        elif kind == 5:
            self.add(self.random.choice(["M48", "M49", "M50 P0", "M51 P1", "M53 P1", "M62 P1", "M63 P2", "M64 P0", "M65 P3", "M67 E0 Q2.5", "M68 E1 Q3"]))
        elif kind == 6:
            self.add(self.random.choice(["G61", "G64 P0.05 Q0.02", "G64"]))
        elif kind == 7:
            self.add(self.random.choice(["M70", "M71", "M72", "M70"] if self.depth == 0 else ["M9", "S1000 M4"]))
        else:
            self.wrong()

    def wrong(self):
        """A line that should be refused, or at least be read alike."""
        if self.random.random() < 0.85:
            return self.move()
        self.lines.append(self.random.choice([
            "G0 G1 X1", "G90 G91", "X1 X2 G0", "G1", "G2 X1", "G1 X[1/0]", "#0 = 1", "G0 X#99999", "G4", "G10 L2 P1 X1 Y", "G10 L2 P12 X1", "G92",
            "G53 X1", "G81 Z-1", "M3 M5", "G0 X1 Y", "G0 X-", "G0 X[1", "G0 X1]", "G43 H77", "G5.9", "M198", "G17 G18", "G0 X1 G4 P1", "G28 G0 X1",
            "G1 X1 I2", "G0 X1 R3", "G0 X1 P2", "G0 X1 L2", "T-1", "S-1", "F-1", "G0 X1.2.3", "G0 X+5", "G0 X--5", "G0 X 5", "G 0 X5", "G0 X1 ( open",
            "O900 endif", "O901 if [1]", "#<q>=1 #<q>=2 G0 X#<q>", "G0 X[#<nobody>]", "G0 X[SQRT[0-1]]", "G0 X[ACOS[2]]", "G0 X[LN[0]]", "G0 X[2**-1]",
            "G0 X[1 2]", "G0 X[[1]]", "G0 X[-[1]]", "G0 X-[1]", "G0 X-#1", "G0 X[1+-2]", "G0 X[EXISTS[#<nobody>]]", "G0 X[1EQ1]", "G0 X[7MOD-3]",
            "G0 X##1", "G0 X#[1+1]", "#[1+1]=3", "G0 X[ROUND[-0.5]]", "G0 X[ROUND[2.5]]", "G0 X[FIX[-2.5]]", "G0 X[0-2**2]", "G0 X[2**3**2]", "M2.5", "G1.5 X1",
            "G80 X1", "G80 G0 X1", "G0.0 X1", "G01 X1 F100", "G1X1Y1F100", "N5", "N1.5 G0 X1", "G0 x1y2", "A1", "G0 D1", "G61 P1", "G64 P-1", "M6", "M0 M1",
        ]))

    def program(self):
        self.lines = ["G21 G90 G17 G94 G99 G54 G91.1", "F500"]
        for _ in range(self.random.randint(4, 22)):
            self.line()
        return self.lines

    def line(self):
        productions = [self.move] * 6 + [self.modal] * 3 + [self.offsets] * 3 + [self.arc] * 2 + [self.cycle, self.parameter, self.parameter, self.flow, self.other, self.other]
        self.random.choice(productions)()


def program_of(seed):
    """The lines of a program, without its end."""
    return Maker(seed).program()
