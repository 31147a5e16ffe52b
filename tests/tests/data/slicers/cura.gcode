;FLAVOR:Marlin
;TIME:90
;Filament used: 0.0016m
;Layer height: 0.2
;Generated with Cura_SteamEngine 5.4.0
M140 S30
M105
M190 S30
M104 S60
M105
M109 S60
M82 ;absolute extrusion mode
M201 X500.00 Y500.00 Z100.00 E5000.00 ;Setup machine max acceleration
M203 X500.00 Y500.00 Z10.00 E50.00 ;Setup machine max feedrate
M204 P500.00 R1000.00 T500.00 ;Setup Print/Retract/Travel acceleration
M205 X8.00 Y8.00 Z0.40 E5.00 ;Setup Jerk
M220 S100 ;Reset Feedrate
M221 S100 ;Reset Flowrate
G28 ;Home
G92 E0 ;Reset Extruder
G1 Z2.0 F3000 ;Move Z Axis up
G92 E0
;LAYER_COUNT:1
;LAYER:0
M107
M204 S500
M205 X10 Y10
;MESH:cube.stl
G0 F6000 X50 Y50 Z0.2
;TYPE:WALL-OUTER
G1 F1200 X60 Y50 E0.4
G1 X60 Y60 E0.8
M106 S255
G1 X50 Y60 E1.2
G1 X50 Y50 E1.6
M300 S440 P200
;TIME_ELAPSED:80
M140 S0
G91 ;Relative positioning
G1 E-2 F2700 ;Retract a bit
G1 E-2 Z0.2 F2400 ;Retract and raise Z
G1 X5 Y5 F3000 ;Wipe out
G1 Z10 ;Raise Z more
G90 ;Absolute positioning
G1 X0 Y100 ;Present print
M106 S0 ;Turn-off fan
M104 S0 ;Turn-off hotend
M140 S0 ;Turn-off bed
M84 X Y E ;Disable all steppers but Z
M82 ;absolute extrusion mode
M104 S0
;End of Gcode
;SETTING_3 {}
