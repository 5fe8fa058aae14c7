/* SPDX-License-Identifier: MIT
 * gen_names.h - the generator's internal functions under names that cannot meet a user's.
 *
 * libsteinlab.a contains the generator, so that its functions would otherwise occupy short names
 * like vec_add in every program that links it. As zlib's Z_PREFIX.
 * Included by: this folder.
 */
#ifndef GEN_NAMES_H
#define GEN_NAMES_H

#define along_inverse    gen__along_inverse
#define along_pose       gen__along_pose
#define angle_trig       gen__angle_trig
#define derive_along     gen__derive_along
#define derive_by_state  gen__derive_by_state
#define dyn_articulated  gen__dyn_articulated
#define dyn_articulates  gen__dyn_articulates
#define dyn_bias         gen__dyn_bias
#define dyn_inverse      gen__dyn_inverse
#define dyn_mass_bias    gen__dyn_mass_bias
#define dyn_unloaded     gen__dyn_unloaded
#define emit_func        gen__emit_func
#define emit_functions   gen__emit_functions
#define emit_header      gen__emit_header
#define emit_model       gen__emit_model
#define emit_setup       gen__emit_setup
#define emit_setup_along gen__emit_setup_along
#define emit_slopes      gen__emit_slopes
#define emit_tables      gen__emit_tables
#define ex_add           gen__ex_add
#define ex_const         gen__ex_const
#define ex_count         gen__ex_count
#define ex_div           gen__ex_div
#define ex_eval          gen__ex_eval
#define ex_fun           gen__ex_fun
#define ex_graph_free    gen__ex_graph_free
#define ex_graph_init    gen__ex_graph_init
#define ex_is_num        gen__ex_is_num
#define ex_mul           gen__ex_mul
#define ex_name          gen__ex_name
#define ex_neg           gen__ex_neg
#define ex_num           gen__ex_num
#define ex_reach         gen__ex_reach
#define ex_sub           gen__ex_sub
#define ex_var           gen__ex_var
#define func_build       gen__func_build
#define func_free        gen__func_free
#define func_like        gen__func_like
#define func_search      gen__func_search
#define hash_bytes       gen__hash_bytes
#define kin_bend         gen__kin_bend
#define kin_energy       gen__kin_energy
#define kin_place        gen__kin_place
#define kin_point        gen__kin_point
#define kin_pose         gen__kin_pose
#define layout_add_func  gen__layout_add_func
#define layout_build     gen__layout_build
#define layout_find      gen__layout_find
#define layout_free      gen__layout_free
#define loop_closure     gen__loop_closure
#define loop_rows        gen__loop_rows
#define loop_units       gen__loop_units
#define rotate           gen__rotate
#define rotate_mat       gen__rotate_mat
#define rotate_sym       gen__rotate_sym
#define same_group       gen__same_group
#define slope_inverse    gen__slope_inverse
#define solve_ops        gen__solve_ops
#define sym_add          gen__sym_add
#define sym_add_cross    gen__sym_add_cross
#define sym_apply        gen__sym_apply
#define sym_column       gen__sym_column
#define sym_const        gen__sym_const
#define sym_cross        gen__sym_cross
#define sym_entry        gen__sym_entry
#define sym_point        gen__sym_point
#define text_add         gen__text_add
#define text_init        gen__text_init
#define text_literal     gen__text_literal
#define text_number      gen__text_number
#define text_quiet       gen__text_quiet
#define text_safe        gen__text_safe
#define tree_build       gen__tree_build
#define tree_free        gen__tree_free
#define tree_scalar      gen__tree_scalar
#define tree_vector      gen__tree_vector
#define vec_add          gen__vec_add
#define vec_axis         gen__vec_axis
#define vec_const        gen__vec_const
#define vec_cross        gen__vec_cross
#define vec_dot          gen__vec_dot
#define vec_is_zero      gen__vec_is_zero
#define vec_name         gen__vec_name
#define vec_scale        gen__vec_scale
#define vec_sub          gen__vec_sub
#define vec_zero         gen__vec_zero
#define walk_frames      gen__walk_frames

#endif
