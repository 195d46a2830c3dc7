//! The methods of `Client` and `Framebuffer` for verbs, made from the table: a verb that is added has
//! its methods at once.
//!
//! In: the rows of the table. Out: for each verb a method named as its function, with its arguments
//! in order; but for verbs of this file's list, whose methods are written by hand, with arguments
//! that are easier to write.

/// Gives what is in braces, unless the methods of this function's verb are written by hand.
#[doc(hidden)]
#[macro_export]
macro_rules! unless_written {
    (help $_:tt) => {};
    (size $_:tt) => {};
    (moved_pixel $_:tt) => {};
    (asked_pixel $_:tt) => {};
    (binary_pixel $_:tt) => {};
    (pixel_run $_:tt) => {};
    (set_offset $_:tt) => {};
    (stats $_:tt) => {};
    (quit $_:tt) => {};
    (poke $_:tt) => {};
    (peek $_:tt) => {};
    (blit $_:tt) => {};
    (read $_:tt) => {};
    (copy $_:tt) => {};
    (points $_:tt) => {};
    (crc $_:tt) => {};
    (clear $_:tt) => {};
    (line $_:tt) => {};
    (triangle $_:tt) => {};
    (fill $_:tt) => {};
    (rect $_:tt) => {};
    (fill_rect $_:tt) => {};
    (circle $_:tt) => {};
    (fill_circle $_:tt) => {};
    (poly $_:tt) => {};
    (fill_poly $_:tt) => {};
    (text $_:tt) => {};
    (print $_:tt) => {};
    (wide_line $_:tt) => {};
    (ellipse $_:tt) => {};
    (fill_ellipse $_:tt) => {};
    (arc $_:tt) => {};
    (bezier $_:tt) => {};
    (set_text_size $_:tt) => {};
    (image_job $_:tt) => {};
    (help_on $_:tt) => {};
    (set_size $_:tt) => {};
    (set_clip $_:tt) => {};
    (make_canvas $_:tt) => {};
    (set_target $_:tt) => {};
    (stamp $_:tt) => {};
    (set_title $_:tt) => {};
    (pause $_:tt) => {};
    ($function:ident $made:tt) => {
        $crate::unless_written_elsewhere! { $function $made }
    };
}

/// Gives what is in braces, unless the methods of this function's verb are written by hand; the
/// second half of the list.
#[doc(hidden)]
#[macro_export]
macro_rules! unless_written_elsewhere {
    (line_aa $_:tt) => {};
    (set_blend $_:tt) => {};
    (mesh_job $_:tt) => {};
    (texture_job $_:tt) => {};
    (scene_job $_:tt) => {};
    (eye_job $_:tt) => {};
    (free $_:tt) => {};
    (load_job $_:tt) => {};
    (look_at $_:tt) => {};
    (set_viewport $_:tt) => {};
    (reset_model $_:tt) => {};
    (push_matrix $_:tt) => {};
    (pop_matrix $_:tt) => {};
    (translate_model $_:tt) => {};
    (rotate_model $_:tt) => {};
    (scale_model $_:tt) => {};
    (shear_model $_:tt) => {};
    (multiply_affine $_:tt) => {};
    (set_ambient $_:tt) => {};
    (set_light $_:tt) => {};
    (set_material $_:tt) => {};
    (use_texture $_:tt) => {};
    (set_shade $_:tt) => {};
    (set_cull $_:tt) => {};
    (set_hide $_:tt) => {};
    (set_depth_format $_:tt) => {};
    (set_interpolation $_:tt) => {};
    (draw $_:tt) => {};
    (draw_scene $_:tt) => {};
    (draw_eye $_:tt) => {};
    (set_quality $_:tt) => {};
    (depth_at $_:tt) => {};
    (pick $_:tt) => {};
    (sync $_:tt) => {};
    (hello $_:tt) => {};
    (version $_:tt) => {};
    (set_auto $_:tt) => {};
    (present $_:tt) => {};
    (set_events $_:tt) => {};
    (set_error_mode $_:tt) => {};
    (snap_job $_:tt) => {};
    ($function:ident { $($made:tt)* }) => { $($made)* };
}

/// Gives `$with! { function VERB Variant { field: Type, ... } }` for each figure.
macro_rules! each_figure {
    ($with:ident nested $nested:tt; $($group:ident $encoding:ident $target:ident $rows:tt)*) => {
        $( each_figure! { $with $target $rows } )*
    };
    ($with:ident Figure {$(
        $verb:ident $variant:ident
        { $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? }
        = fn $function:ident
        $(with $($hooked:ident = $hook:ident),+)?
        $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*}) => {
        $( $with! { $function $verb $variant { $($f: $t),* } } )*
    };
    ($with:ident $target:ident $rows:tt) => {};
}

pub(crate) use each_figure;
