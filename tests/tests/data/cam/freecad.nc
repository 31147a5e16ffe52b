(Exported by FreeCAD)
(Post Processor: grbl_post)
(Output Time:2024-03-01 10:00:00.000000)
(Begin preamble)
G17 G90
G21
(Begin operation: Fixture)
(Path: Fixture)
G54
(Finish operation: Fixture)
(Begin operation: TC: 6mm Endmill)
(Path: TC: 6mm Endmill)
(TC: 6mm Endmill)
(Begin toolchange)
( M6 T1 )
M3 S12000
(Finish operation: TC: 6mm Endmill)
(Begin operation: Profile)
(Path: Profile)
(Profile)
(Compensated Tool Path. Diameter: 6.0)
G0 Z11.000
G0 X43.000 Y30.000
G0 Z9.000
G1 X43.000 Y30.000 Z1.000 F200.000
G2 X40.000 Y27.000 Z1.000 I-3.000 J-0.000 K0.000 F600.000
G1 X10.000 Y27.000 Z1.000 F600.000
G2 X7.000 Y30.000 Z0.500 I0.000 J3.000 K0.000 F600.000
G1 X7.000 Y40.000 Z0.500 F600.000
G2 X10.000 Y43.000 Z0.000 I3.000 J0.000 K0.000 F600.000
G1 X40.000 Y43.000 Z0.000 F600.000
G0 Z11.000
G0 Z11.000
(Finish operation: Profile)
(Begin operation: Drilling)
G0 X20.000 Y35.000
G0 Z5.000
G1 Z-3.000 F120.000
G4 P0.500
G0 Z5.000
(Finish operation: Drilling)
(Begin postamble)
M5
G17 G90
M2
