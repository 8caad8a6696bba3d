; HEADER_BLOCK_START
; BambuStudio 02.03.01.51
; estimated printing time (normal mode) = 5m 38s
; total layer number: 50
; HEADER_BLOCK_END

; CONFIG_BLOCK_START
; bottom_shell_layers = 3
; bottom_shell_thickness = 0
; inner_wall_line_width = 0.45
; layer_height = 0.2
; line_width = 0.42
; nozzle_diameter = 0.4
; outer_wall_line_width = 0.42
; sparse_infill_density = 15%
; sparse_infill_line_width = 0.45
; sparse_infill_pattern = gyroid
; spiral_mode = 0
; top_shell_layers = 5
; top_shell_thickness = 0
; wall_loops = 2
; CONFIG_BLOCK_END

G28
G1 X1 Y1
