# SPDX-License-Identifier: GPL-3.0-or-later
"""What each document tested, on which machine, and the figures in its print."""
from dataclasses import dataclass, field

ALL = ("dx", "dy", "dz")
SURROUNDINGS = "T_s"  # the air in records with differences, which are against what their document says
MIDDLE = "X=0,Y=0,Z=275,B=0"
# Six places in a plane as of the spheres of 001, Table 1: corners of Y and Z and two between them.
SPHERES = ["X=0,Y=325,Z=0,B=0", "X=0,Y=0,Z=10,B=0", "X=0,Y=-325,Z=10,B=0", "X=0,Y=-130,Z=385,B=0",
           "X=0,Y=325,Z=550,B=0", "X=0,Y=-325,Z=550,B=0"]
# A face-centred cube and three poses between.
CUBE = [f"X={x},Y={y},Z={z},B=0" for x in (-400, 0, 400) for y in (-325, 0, 325) for z in (0, 275, 550)
        if (x == 0) + (y == 0) + (z == 275) in (0, 2)]
SPINDLE = ["T1", "air.T_C"]
MIDDLE_AC = "X=0,Y=0,Z=225,A=0"
OF_A = ["a_hold_90_16h", "a_pendular_16h"]
BETWEEN = ["X=-250,Y=120,Z=150,B=0", "X=180,Y=-210,Z=330,B=0", "X=310,Y=240,Z=440,B=0"]


@dataclass
class Test:
    document: str
    name: str
    models: list
    train: list                # load programs
    judge: str                 # load program
    published: dict            # by quantity; "all": of all together
    measure: str = "rms"       # rms, range, fit or times
    quantities: tuple = ALL
    poses: list = field(default_factory=list)   # where it is measured; empty: check points of the case
    check: list = field(default_factory=list)   # of them: places, from 0, that no fit may use
    differences: dict = field(default_factory=dict)  # inputs: name -> (sensor, sensor)
    inputs: list = field(default_factory=list)  # inputs that the models may use; empty: all
    start_h: float = 0         # of each record; before it the machine settles
    hours: float = 0           # of each record from there; 0: whole
    from_campaign: bool = False  # trains on tables of the nominal model at the grid and all tilts
    power: tuple = ()          # sources whose power the record has
    second: bool = False       # on the second case, the A/C machine
    noise: bool = True         # of sensors and probes
    perturb: str = "thermal"   # as of `validate`
    ablation: list = field(default_factory=list)  # (cause, fields that differ): one cause at a time
    trained: str = ""
    judged: str = ""


NO_NOISE = ("no noise", {"noise": False})
STATED = ("parameters as stated", {"perturb": "none"})
OF_001 = [NO_NOISE, STATED, ("all temperatures as inputs", {"inputs": ["T1", "T2", "T3", "T4", "T5", "T9", "air.T_C"]})]

TESTS = [
    Test("000", "table at another speed", ["phenomenological", "rotary_unit"],
         ["table_150", "table_300", "table_1200"], "table_600", {"all": "35 to 58 (6.1)"}, "range",
         trained="150, 300, 1200 rpm, 8 h each", judged="600 rpm, 8 h"),
    Test("000", "swivel axis, drive's power", ["phenomenological", "phenomenological_switched"],
         ["swivel_hold_90_16h", "swivel_pendular_16h"], "swivel_cycle_62h", {"all": "42 to 71 (6.3)"}, "range",
         power=("B.motor",), trained="held at 90 deg and pendular, 20 h each", judged="arbitrary cycle, 62 h",
         ablation=[NO_NOISE, STATED, ("speed in place of the drive's power", {"power": ()}),
                   ("trained on the judged cycle", {"train": ["swivel_cycle_62h"]})]),
    Test("000", "A/C: A axis (Fig. 6.8)", ["phenomenological", "phenomenological_switched"], OF_A, "a_cycle_62h",
         {"dx": "59 (X0T, 6.3)", "dz": "42 (Z0A, 6.3)"}, "range", ("dx", "dz"), [MIDDLE_AC], power=("A.motor",),
         second=True, trained="held at 90 deg and pendular, 20 h each", judged="arbitrary cycle, 62 h",
         ablation=[NO_NOISE, STATED, ("speed in place of the drive's power", {"power": ()}),
                   ("trained on the judged cycle", {"train": ["a_cycle_62h"]})]),
    Test("000", "A/C: C axis (Figs. 5.18, 5.19)", ["phenomenological", "rotary_unit"], ["table_cycle_73h"],
         "table_cycle_83h", {"all": "curves only (5.22)"}, "range", ("dx", "dy", "dz"), [MIDDLE_AC],
         power=("C.motor",), second=True, trained="random cycle, 73 h", judged="another, 83 h"),
    Test("000", "A/C: A and C (Fig. 6.13)", ["phenomenological", "phenomenological_switched"],
         [*OF_A, "table_cycle_73h"], "ac_cycle_36h", {"dx": "48 (X0C, 6.4)", "dz": "62 (Z0T, 6.4)"}, "range",
         ("dx", "dz"), [MIDDLE_AC], power=("A.motor", "C.motor"), second=True,
         trained="A held and pendular, C random cycle of 73 h", judged="A and C in turn, 36 h",
         ablation=[NO_NOISE, STATED, ("trained on the judged cycle", {"train": ["ac_cycle_36h"]})]),
    Test("001", "calibration", ["one_point", "transfer_grid"], ["settled_spindle_3000"], "settled_spindle_3000",
         {"dz": "90 to 95 (Table 3)"}, "fit", ("dz",), SPHERES, [1, 3], inputs=SPINDLE, start_h=48, hours=4,
         trained="3000 rpm, heating, places 1, 3, 5, 6", judged="the same test", ablation=OF_001),
    Test("001", "four times the speed", ["one_point", "transfer_grid"], ["settled_spindle_3000"],
         "settled_spindle_12000", {"dz": "63 to 85, mean 76 (Table 4)"}, "fit", ("dz",), SPHERES, [1, 3],
         inputs=SPINDLE, start_h=48, hours=4, trained="3000 rpm, heating, places 1, 3, 5, 6",
         judged="12000 rpm, heating",
         ablation=[*OF_001, ("trained at the judged speed", {"train": ["settled_spindle_12000"]})]),
    Test("001", "face-centred cube", ["one_point", "transfer_grid"], ["settled_spindle_12000"], "settled_spindle_12000",
         {"dz": "over 90 presumed (5)"}, "fit", ("dz",), CUBE + BETWEEN, [len(CUBE) + i for i in range(3)],
         inputs=SPINDLE, start_h=48, hours=4, trained="12000 rpm, heating, 14 places",
         judged="the same test, three more"),
    Test("003", "both validations", [], [], "validation_21C", {"all": "56 to 72"}),  # see naumann.py
    Test("004", "air cutting", [], [], "air_cutting", {"dy": "7.5", "dz": "2.5"}, "times"),  # see mares_2019.py
]

TITLES = {"000": "Gebhardt (2014)", "001": "Okénka et al.", "002": "Mareš et al. (2020)",
          "003": "Naumann et al. (2023)", "004": "Mareš et al. (2019)"}
MEASURES = {"rms": "RMS removed, %", "range": "range removed, %", "fit": "fit, %", "times": "range, times smaller"}
