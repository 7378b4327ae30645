// Cooling pin: a pipe along y with 6 rings of 12 wings. Angles run from +z towards +x, the positive sense
// about +y, so that (tangent, y, radial) is right-handed.

#include <cmath>
#include <numbers>

#include "sim/parts/facet_mesh.h"

namespace tiltfeed::sim {
namespace {

constexpr std::size_t kPinFacets = 55'818;
constexpr double kBoreRadius = 7.0, kPipeRadius = 10.0, kTipRadius = 23.0;
constexpr double kHalfThickness = 1.0;  ///< of a wing: its sides are planes
constexpr int kWings = 12, kRings = 6;
constexpr double kPitch = 2.0 * std::numbers::pi / kWings;
// Cells of about 1 mm along y and r; across, 3 cells on a wing and 4 in the gap hold the chord error on the
// pipe below 0.01 mm.
constexpr int kRows = 62, kMargin = 3, kWingRows = 6, kRingPitch = 10;
constexpr int kWingColumns = 3, kGapColumns = 4, kPitchColumns = kWingColumns + kGapColumns;
constexpr int kColumns = kWings * kPitchColumns;
constexpr int kWingCells = 13;  ///< from pipe to tip
constexpr int kWallCells = 3;   ///< from bore to pipe, on the end faces

Vec3 at_angle(double angle, double radius, double y) {
  return {radius * std::sin(angle), y, radius * std::cos(angle)};
}

double wing_offset(int column) { return kHalfThickness * (2.0 * column / kWingColumns - 1.0); }

/// Angle of a column on the pipe's outside, from the middle of its pitch's wing.
double outer_angle(int column_in_pitch) {
  const double edge = std::asin(kHalfThickness / kPipeRadius);
  if (column_in_pitch <= kWingColumns) return std::asin(wing_offset(column_in_pitch) / kPipeRadius);
  return edge + (kPitch - 2.0 * edge) * (column_in_pitch - kWingColumns) / kGapColumns;
}

/// A point of a wing: across its thickness, along y, and up from the pipe (0) to the tip (kWingCells).
Vec3 wing_point(int wing, int column, double y, int level) {
  const double across = wing_offset(column);
  const double root = std::sqrt(kPipeRadius * kPipeRadius - across * across);
  const double tip = std::sqrt(kTipRadius * kTipRadius - across * across);
  const double up = root + (tip - root) * level / kWingCells;
  const double s = std::sin(kPitch * wing), c = std::cos(kPitch * wing);
  return {up * s + across * c, y, up * c - across * s};
}

class Pin {
 public:
  FacetMesh build() && {
    add_pipe_vertices();
    add_pipe();
    for (int ring = 0; ring < kRings; ++ring)
      for (int wing = 0; wing < kWings; ++wing) add_wing(wing, kMargin + ring * kRingPitch);
    return std::move(mesh_);
  }

 private:
  static bool under_wing(int column, int row) {
    const int above = row - kMargin;
    return column % kPitchColumns < kWingColumns && above >= 0 && above % kRingPitch < kWingRows &&
           above / kRingPitch < kRings;
  }
  /// Grid points of the pipe that no facet uses: strictly inside a wing's foot.
  static bool is_buried(int column, int row) {
    return under_wing(column, row) && under_wing(column, row - 1) && column % kPitchColumns > 0;
  }
  static int wrapped(int column) { return column % kColumns; }
  std::uint32_t outer(int column, int row) const { return outer_[wrapped(column) * (kRows + 1) + row]; }
  std::uint32_t bore(int column, int row) const { return bore_[wrapped(column) * (kRows + 1) + row]; }

  void add_pipe_vertices() {
    for (int column = 0; column < kColumns; ++column) {
      const int wing = column / kPitchColumns, in_pitch = column % kPitchColumns;
      const double bore_angle =
          kPitch * (wing + (in_pitch - 0.5 * kWingColumns) / static_cast<double>(kPitchColumns));
      for (int row = 0; row <= kRows; ++row) {
        const Vec3 outside = in_pitch <= kWingColumns
                                 ? wing_point(wing, in_pitch, row, 0)
                                 : at_angle(kPitch * wing + outer_angle(in_pitch), kPipeRadius, row);
        outer_.push_back(is_buried(column, row) ? 0 : add_vertex(mesh_, outside));
        bore_.push_back(add_vertex(mesh_, at_angle(bore_angle, kBoreRadius, row)));
      }
    }
  }

  void add_pipe() {
    for (int column = 0; column < kColumns; ++column) {
      for (int row = 0; row < kRows; ++row) {
        add_quad(mesh_, bore(column, row), bore(column, row + 1), bore(column + 1, row + 1),
                 bore(column + 1, row));
        if (!under_wing(column, row))
          add_quad(mesh_, outer(column, row), outer(column + 1, row), outer(column + 1, row + 1),
                   outer(column, row + 1));
      }
    }
    add_end_face(0);
    add_end_face(kRows);
  }

  void add_end_face(int row) {
    std::vector<std::uint32_t> nodes;
    for (int column = 0; column < kColumns; ++column) {
      const Vec3 in = from_origin(mesh_.vertices[bore(column, row)]);
      const Vec3 out = from_origin(mesh_.vertices[outer(column, row)]);
      nodes.push_back(bore(column, row));
      for (int cell = 1; cell < kWallCells; ++cell)
        nodes.push_back(add_vertex(mesh_, in + (out - in) * cell / kWallCells));
      nodes.push_back(outer(column, row));
    }
    const auto node = [&](int column, int cell) { return nodes[wrapped(column) * (kWallCells + 1) + cell]; };
    for (int column = 0; column < kColumns; ++column) {
      for (int cell = 0; cell < kWallCells; ++cell) {
        const std::uint32_t a = node(column, cell), b = node(column, cell + 1);
        const std::uint32_t c = node(column + 1, cell + 1), d = node(column + 1, cell);
        if (row == 0)
          add_quad(mesh_, a, d, c, b);
        else
          add_quad(mesh_, a, b, c, d);
      }
    }
  }

  void add_wing(int wing, int first_row) {
    constexpr int kAcross = kWingColumns + 1, kAlong = kWingRows + 1, kUp = kWingCells + 1;
    std::array<std::uint32_t, kAcross * kAlong * kUp> nodes{};
    const auto node = [&](int column, int row, int level) -> std::uint32_t& {
      return nodes[(level * kAlong + row) * kAcross + column];
    };
    for (int level = 0; level < kUp; ++level) {
      for (int row = 0; row < kAlong; ++row) {
        for (int column = 0; column < kAcross; ++column) {
          const bool skin = row == 0 || row == kWingRows || column == 0 || column == kWingColumns;
          if (level == 0 && skin)
            node(column, row, level) = outer(wing * kPitchColumns + column, first_row + row);
          else if (skin || level == kWingCells)
            node(column, row, level) = add_vertex(mesh_, wing_point(wing, column, first_row + row, level));
        }
      }
    }
    for (int row = 0; row < kWingRows; ++row)
      for (int column = 0; column < kWingColumns; ++column)
        add_quad(mesh_, node(column, row, kWingCells), node(column + 1, row, kWingCells),
                 node(column + 1, row + 1, kWingCells), node(column, row + 1, kWingCells));
    for (int level = 0; level < kWingCells; ++level) {
      for (int row = 0; row < kWingRows; ++row) {
        add_quad(mesh_, node(kWingColumns, row, level), node(kWingColumns, row + 1, level),
                 node(kWingColumns, row + 1, level + 1), node(kWingColumns, row, level + 1));
        add_quad(mesh_, node(0, row, level), node(0, row, level + 1), node(0, row + 1, level + 1),
                 node(0, row + 1, level));
      }
      for (int column = 0; column < kWingColumns; ++column) {
        add_quad(mesh_, node(column, kWingRows, level), node(column, kWingRows, level + 1),
                 node(column + 1, kWingRows, level + 1), node(column + 1, kWingRows, level));
        add_quad(mesh_, node(column, 0, level), node(column + 1, 0, level), node(column + 1, 0, level + 1),
                 node(column, 0, level + 1));
      }
    }
  }

  FacetMesh mesh_;
  std::vector<std::uint32_t> outer_, bore_;
};

}  // namespace

Triangles cooling_pin() {
  FacetMesh mesh = Pin().build();
  // The longest edges are diagonals of the wings' plane sides: their middles are straight.
  split_longest_edges(mesh, kPinFacets,
                      [&](std::uint32_t a, std::uint32_t b) { return straight_midpoint(mesh, a, b); });
  return to_triangles(mesh);
}

}  // namespace tiltfeed::sim
