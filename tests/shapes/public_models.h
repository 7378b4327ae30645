#pragma once
// The STL files of ../shared/models (local test data, part of no release): the answer each must get, and an
// axis frame and ball to plan it with.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::models {
using namespace pathgen;

/// Counts by DefectKind.
struct Defects {
  std::uint64_t degenerate = 0, duplicate = 0, open = 0, non_manifold = 0, misoriented = 0, flipped = 0,
                inside_out = 0, welded = 0, split = 0, flaps = 0, separated = 0, filled = 0;
  bool operator==(const Defects&) const = default;
};

/// What the models' index says of the file as it is: corners welded exactly, facets with a corner twice not
/// counted on edges, duplicates counted.
struct Raw {
  std::uint64_t facets = 0, vertices = 0, open = 0, non_manifold = 0, misoriented = 0;
  bool operator==(const Raw&) const = default;
};

/// In mm, after the unit scale. Where the index names several placements, the most demanding.
struct Placement {
  AxisFrame axis;
  double ball = 0.0;       ///< diameter
  double side_step = 0.0;  ///< coarse
};

struct Model {
  std::string file;  ///< below the models' folder, without .stl
  double unit_mm = 1.0;
  bool refused = false;
  Code code = Code::kInput;  ///< of a refusal
  std::string message = {};  ///< a piece of the refusal
  Raw raw = {};
  Defects defects = {};  ///< none: planned clean; else planned with one warning for each
  int added = 0;         ///< facets by cuts and fills; less those that a weld collapses
  Sides sides = Sides::kOutward;
  double volume = 0.0;      ///< where sides is kOutward: in the file's unit, of the repaired part
  std::string oddity = {};  ///< a piece of the reader's only warning; empty: it has none
  Placement placement = {};
};

inline AxisFrame fixed() { return {}; }
inline AxisFrame point(Point<Part> origin, Vec3 t, Vec3 n, Sense sense = Sense::kOutward) {
  return {AxisMode::kPoint, sense, origin, t, n, 0.0};
}
inline AxisFrame line(Point<Part> origin, Vec3 t, Vec3 n) {
  return {AxisMode::kLine, Sense::kOutward, origin, t, n, 0.0};
}
inline AxisFrame circle(Point<Part> origin, double radius, Vec3 t, Vec3 n, Sense sense = Sense::kOutward) {
  return {AxisMode::kCircle, sense, origin, t, n, radius};
}

inline Model sound(std::string file, double unit_mm, Raw raw, double volume, Placement placement,
                   std::string oddity = "") {
  return {.file = file,
          .unit_mm = unit_mm,
          .raw = raw,
          .volume = volume,
          .oddity = oddity,
          .placement = placement};
}
inline Model repaired(std::string file, double unit_mm, Raw raw, Defects defects, double volume,
                      Placement placement) {
  return {.file = file,
          .unit_mm = unit_mm,
          .raw = raw,
          .defects = defects,
          .volume = volume,
          .placement = placement};
}
/// The same, `added` facets.
inline Model closed(std::string file, Raw raw, Defects defects, int added, double volume,
                    Placement placement) {
  Model model = repaired(file, 1, raw, defects, volume, placement);
  model.added = added;
  return model;
}
/// Planned with both sides as surface.
inline Model both_sides(std::string file, double unit_mm, Raw raw, Defects defects, Placement placement) {
  return {.file = file,
          .unit_mm = unit_mm,
          .raw = raw,
          .defects = defects,
          .sides = Sides::kBoth,
          .placement = placement};
}
inline Model refused(std::string file, Code code, std::string message) {
  return {.file = file, .refused = true, .code = code, .message = message};
}

inline std::vector<Model> all() {
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const Vec3 hole{0, -0.57735026918962576, 0.81649658092772603};  // the sphere's, perpendicular to x
  const Vec3 gap{0.25881904510252076, 0, 0.96592582628906829};    // the pin's: 15 degrees from z
  const Placement knob{point({0, -5, 125}, x, z), 5, 3};
  const Placement tooth{point({0, 24.2, -5.4}, x, z), 1, 0.5};
  const Placement half_donut{circle({1.5, 0, 1.5}, 1.0, x, -z), 0.5, 0.2};
  const Placement sphere{point({0, 0, 0}, x, hole), 10, 5};
  const Placement handle{line({0, 0, 36}, x, z), 6, 3};
  return {
      sound("public/tyre_tb3", 1, {21672, 10812}, 27817.6, {circle({0, 0, 0}, 24, x, -z), 4, 3}),
      sound("public/propeller_d", 1, {7952, 3978}, 10300.5, {line({213.1, 36.1, 34.3}, x, z), 4, 2}),
      sound("public/impeller_aero", 1, {65304, 32652}, 8321.85, {point({-200, 175, -70}, x, z), 4, 3}),
      repaired("public/blade_nasa", 1000, {14240, 7120}, {.degenerate = 4}, 7.24445e-06,
               {line({-44, 27, 0}, z, y), 3, 2}),
      sound("public/knob_shifter", 1, {17078, 8541}, 65496.3, knob),
      sound("public/tooth_molar", 1, {3878, 1941}, 526.449, tooth),
      sound("public/mould_cavity", 25.4, {4090, 2041}, 18.1754,
            {point({0, -150, 3}, x, y, Sense::kInward), 3, 3}),
      sound("public/heatsink_finpack", 1, {5344, 2624}, 48747.3, {line({-3, 0, -20}, y, z), 2, 2}),
      both_sides("public/tube_3legs", 1, {5519, 2831, 147}, {.open = 147}, {point({0, 0, 100}, x, z), 6, 5}),
      sound("public/ring_ftc11", 1, {43002, 21501}, 5103.72, {circle({0, 0, 0}, 29, y, x), 2, 1}),
      // 3588 facets have a corner twice, 15 more are lower than kMinHeight; a folded flap hangs on one edge,
      // and goes with two facets when its corners are welded.
      closed("public/part_ctc01", {95196, 45786, 0, 1},
             {.degenerate = 3603, .duplicate = 1, .open = 2, .non_manifold = 1, .welded = 2}, -3, 1.46404e+07,
             {fixed(), 20, 20}),
      sound("public/femur", 1, {7904, 3954}, 458399, {line({-8.7, 6.8, 0}, z, x), 6, 5}),
      both_sides("public/bunny_open", 1000, {69451, 34834, 223}, {.open = 223},
                 {point({-26.8, 94, 8.3}, x, y), 6, 4}),
      sound("public/wheel_in_box", 1, {6102, 3043}, 929792, {fixed(), 6, 5}),
      sound("public/flange_multisolid", 1000, {6468, 3228}, 1.56231e-05, {line({0, 0, -10.75}, y, z), 4, 2},
            "4 solids are read as one part"),
      // Volumes of files with missing facets are theirs with the facet on each rim of three edges added.
      closed("public/sphere_with_hole", {285, 146, 9}, {.open = 9, .filled = 3}, 3, 13.58157,
             {point({1.5, 1.5, 1.5}, x, z), 0.5, 0.2}),
      sound("public/halfdonut_solidbin", 1, {288, 144}, 2.34315, half_donut,
            "1 bytes after the last facet are ignored"),
      sound("public/box_nonstandard", 1, {12, 8}, 8000, {point({10, 10, 10}, x, z), 3, 2}),
      repaired("public/bust_inverted", 1, {4630, 2317}, {.degenerate = 1, .inside_out = 1}, 1408.44,
               {line({0, 0, -20}, y, z), 2, 1}),
      both_sides("public/rushmore_nonmanifold", 1, {15592, 7720, 862, 1645, 686},
                 {.degenerate = 14, .duplicate = 407, .open = 878, .non_manifold = 661, .misoriented = 708},
                 {fixed(), 3, 2}),
      both_sides("public/spider_ascii", 1, {1368, 722, 72, 0, 10},
                 {.degenerate = 56, .open = 72, .misoriented = 10, .flipped = 4},
                 {point({0.1, 0, 0.3}, x, z), 0.5, 0.3}),
      sound("public/piston", 1, {36074, 18035}, 178933.6, {line({40, 40, 0}, z, x), 4, 2}),
      both_sides("public/bladex", 0.1, {6899, 3446, 0, 20},
                 {.degenerate = 14, .duplicate = 20, .open = 25, .non_manifold = 5},
                 {line({0, 0, 0}, x, z), 2, 0.75}),
      refused("public/bad_truncated_binary", Code::kInput,
              "says 21672 facets (1083684 bytes), but the file is 700013 bytes: 13998 whole facets and 29 "
              "bytes; the "
              "file is cut short"),
      refused("public/bad_count_too_high", Code::kInput,
              "says 4878 facets (243984 bytes), but the file is 193984 bytes: 3878 whole facets and 0 bytes"),
      refused("public/bad_nan_vertices", Code::kMesh,
              "7 facets have NaN or infinite coordinates, the first is facet"),
      refused("public/bad_comma_decimals", Code::kInput, ":4: facet 0: \"1,324000\" has a decimal comma"),
      repaired("public/bad_duplicate_degenerate", 1, {369, 149, 10, 187}, {.degenerate = 9, .duplicate = 72},
               2.34315, half_donut),
      repaired("public/bad_random_flips", 1, {3878, 1941, 0, 0, 1092}, {.misoriented = 1092, .flipped = 402},
               526.449, tooth),
      closed("public/bad_cracks_1e-4", {17078, 51234, 51234}, {.open = 51234, .welded = 42693}, 0, 65496.3,
             knob),
      refused("public/bad_zero_bytes", Code::kInput, "the file is empty"),
      closed("paper/sphere_4445", {4445, 2221, 3}, {.open = 3, .split = 1}, 1, 223029, sphere),
      sound("paper/sphere_4446_closed", 1, {4446, 2221}, 223032, sphere),
      closed("paper/handle_23779", {23779, 11892, 3}, {.open = 3, .split = 1}, 1, 49184.6, handle),
      sound("paper/handle_23780_closed", 1, {23780, 11892}, 49184, handle),
      sound("paper/pin_55818", 1, {55818, 27909}, 21166, {line({0, 0, 0}, y, gap), 2, 1}),
      sound("paper/tyre_236748", 1, {236748, 118376}, 2141490,
            {circle({0, 0, 0}, 280, x, -z, Sense::kInward), 2, 2}),
  };
}

}  // namespace tiltfeed::models
