"""A printer's status as Klipper gives it, made up: once at rest and once in a print."""


def tuple_of(*values):
    return {"tuple": list(values)}


def settings():
    axis = {"position_min": 0.0, "position_max": 250.0, "position_endstop": 0.0, "homing_speed": 40.0}
    return {
        "printer": {"kinematics": "corexy", "max_velocity": 300.0, "max_accel": 3000.0, "max_z_velocity": 15.0},
        "extruder": {"min_extrude_temp": 170.0, "max_temp": 280.0, "nozzle_diameter": 0.4, "filament_diameter": 1.75},
        "heater_bed": {"max_temp": 120.0, "min_temp": 0.0},
        "stepper_x": axis,
        "stepper_y": axis | {"position_max": 210.5},
        "stepper_z": axis | {"position_min": -5.0, "position_max": 200.0},
        "bed_mesh": {"mesh_min": [10.0, 10.0], "mesh_max": [240.0, 200.0], "probe_count": [5, 5], "algorithm": "bicubic"},
        "idle_timeout": {"timeout": 600.0, "gcode": "M84"},
        "probe": {"x_offset": 0.0, "y_offset": 25.0, "z_offset": 1.25, "speed": 5.0},
        "firmware_retraction": {"retract_length": 0.5, "retract_speed": 30.0},
        "safe_z_home": {"home_xy_position": [125.0, 105.0], "z_hop": 10.0, "speed": 50.0},
        "virtual_sdcard": {"path": "~/gcodes"},
        "pause_resume": {"recover_velocity": 50.0},
    }


def rest():
    return {
        "toolhead": {
            "homed_axes": "", "axis_minimum": tuple_of(0.0, 0.0, -5.0, 0.0), "axis_maximum": tuple_of(250.0, 210.5, 200.0, 0.0),
            "position": tuple_of(0.0, 0.0, 0.0, 0.0), "extruder": "extruder", "max_velocity": 300.0, "max_accel": 3000.0,
            "minimum_cruise_ratio": 0.5, "square_corner_velocity": 5.0, "print_time": 12.25, "stalls": 0,
            "estimated_print_time": 12.5, "max_accel_to_decel": 1500.0,
        },
        "gcode_move": {
            "gcode_position": tuple_of(0.0, 0.0, 0.0, 0.0), "position": tuple_of(0.0, 0.0, 0.0, 0.0),
            "homing_origin": tuple_of(0.0, 0.0, 0.0, 0.0), "absolute_coordinates": True, "absolute_extrude": True,
            "speed": 1500.0, "speed_factor": 1.0, "extrude_factor": 1.0,
        },
        "extruder": {"temperature": 21.93, "target": 0.0, "power": 0.0, "can_extrude": False, "pressure_advance": 0.04,
                     "smooth_time": 0.04},
        "heater_bed": {"temperature": 21.5, "target": 0.0, "power": 0.0},
        "fan": {"speed": 0.0, "rpm": None},
        "heaters": {"available_heaters": ["heater_bed", "extruder"], "available_sensors": ["heater_bed", "extruder"]},
        "configfile": {"settings": settings(), "config": {"printer": {"kinematics": "corexy"}}, "save_config_pending": False},
        "idle_timeout": {"state": "Idle", "printing_time": 0.0},
        "pause_resume": {"is_paused": False},
        "print_stats": {"state": "standby", "filename": "", "total_duration": 0.0, "print_duration": 0.0,
                        "filament_used": 0.0, "message": "", "info": {"current_layer": None, "total_layer": None}},
        "virtual_sdcard": {"is_active": False, "file_path": None, "progress": 0.0, "file_position": 0, "file_size": 0},
        "display_status": {"progress": 0.0, "message": None},
        "save_variables": {"variables": {"literal": "{'offset': -0.25, 'tool': 1, 'name': 'PLA', 'list': [1, 2.5, 'a']}"}},
        "bed_mesh": {"profile_name": "", "mesh_min": [0.0, 0.0], "mesh_max": [0.0, 0.0], "probed_matrix": [[]],
                     "mesh_matrix": [[]], "profiles": {"default": {"points": [[0.1, 0.2], [0.3, -0.1]]}}},
        "quad_gantry_level": {"applied": False}, "z_tilt": {"applied": False},
        "exclude_object": {"objects": [], "excluded_objects": [], "current_object": None},
        "probe": {"last_query": False, "last_z_result": 0.0, "name": "probe"},
        "query_endstops": {"last_query": {"x": 0, "y": 0, "z": 1}},
        "firmware_retraction": {"retract_length": 0.5, "retract_speed": 30.0, "unretract_speed": 20.0,
                                "unretract_extra_length": 0.0},
        "system_stats": {"sysload": 0.13, "cputime": 5.5, "memavail": 500000},
        "webhooks": {"state": "ready", "state_message": "Printer is ready"},
        "mcu": {"mcu_version": "v0", "last_stats": {"mcu_awake": 0.001}},
        "stepper_enable": {"steppers": {"stepper_x": False, "extruder": False}},
        "motion_report": {"live_position": tuple_of(0.0, 0.0, 0.0, 0.0), "live_velocity": 0.0},
    }


def printing():
    status = rest()
    status["toolhead"] |= {
        "homed_axes": "xyz", "position": tuple_of(120.5, 88.25, 12.2, 310.07), "print_time": 1234.5678,
        "max_accel": 5000.0, "estimated_print_time": 1233.9,
    }
    status["gcode_move"] |= {
        "gcode_position": tuple_of(120.5, 88.25, 12.0, 310.07), "position": tuple_of(120.5, 88.25, 12.2, 310.07),
        "homing_origin": tuple_of(0.0, 0.0, 0.2, 0.0), "absolute_extrude": False, "speed": 6000.0, "speed_factor": 1.1,
    }
    status["extruder"] |= {"temperature": 214.97, "target": 215.0, "power": 0.31, "can_extrude": True}
    status["heater_bed"] |= {"temperature": 60.02, "target": 60.0, "power": 0.2}
    status["fan"] |= {"speed": 0.75, "rpm": 4321.5}
    status["idle_timeout"] |= {"state": "Printing", "printing_time": 1234.5}
    status["pause_resume"] |= {"is_paused": True}
    status["print_stats"] |= {"state": "printing", "filename": "part 1.gcode", "info": {"current_layer": 12, "total_layer": 90}}
    status["virtual_sdcard"] |= {"is_active": True, "file_path": "/gcodes/part 1.gcode", "progress": 0.37}
    status["bed_mesh"] |= {"profile_name": "default", "probed_matrix": [[0.1, 0.2], [0.3, -0.1]]}
    status["quad_gantry_level"] |= {"applied": True}
    status["exclude_object"] |= {
        "objects": [
            {"name": "A", "center": [50.0, 50.0], "polygon": [[40.0, 40.0], [60.0, 40.0], [60.0, 60.0]]},
            {"name": "B", "center": [100.0, 90.0], "polygon": [[95.5, 80.0], [110.0, 80.0], [110.0, 99.9]]},
        ],
        "current_object": "A",
    }
    status["probe"] |= {"last_query": True, "last_z_result": 1.2375}
    return status


STATES = [rest(), printing()]


def statuses():
    """At rest, and in a print."""
    return STATES
