;FLAVOR:Marlin
;TIME:8235
;Layer height: 0.2
;Generated with Cura_SteamEngine 4.13.1
G28
;End of Gcode
;SETTING_3 {"global_quality": "[general]\\nversion = 4\\nname = Standard #3\\nde
;SETTING_3 finition = custom\\n\\n[metadata]\\ntype = quality_changes\\nquality_
;SETTING_3 type = normal\\nsetting_version = 19\\n\\n[values]\\nadhesion_type = 
;SETTING_3 none\\n\\n", "extruder_quality": ["[general]\\nversion = 4\\nname = S
;SETTING_3 tandard #3\\ndefinition = custom\\n\\n[metadata]\\ntype = quality_cha
;SETTING_3 nges\\nposition = 0\\nsetting_version = 19\\n\\n[values]\\nbottom_lay
;SETTING_3 ers = 3\\ninfill_line_distance = =0 if infill_sparse_density == 0 els
;SETTING_3 e 1\\ninfill_pattern = gyroid\\ninfill_sparse_density = 25\\nline_wid
;SETTING_3 th = 0.4\\ntop_layers = 5\\nwall_line_count = 4\\n\\n"]}
