#pragma once
// The tread of the tyre-mould segment: heights of its ribs, and grid lines that follow their walls.

#include <numbers>
#include <utility>
#include <vector>

namespace tiltfeed::sim {

inline constexpr double kDegree = std::numbers::pi / 180.0;
inline constexpr double kCircleRadius = 280.0, kSectionRadius = 90.0;
inline constexpr double kTheta = 20.0,
                        kPhi = 55.0;  ///< half angles of the sector and of the section, degrees
inline constexpr int kPitches = 9, kPitchCells = 22;
inline constexpr int kThetaCells = kPitches * kPitchCells;

/// Angles are in degrees. Theta is counted in cells, kThetaCells to the sector, before the chevron shears it.
/// Grid lines lie on the feet and tops of the ribs' walls and, on the walls of circumferential ribs, on the
/// height of the lateral ribs that run into them: within a cell the height is constant, or rises from one
/// edge to the opposite one, or differs in one corner only, with the crease along the diagonal from it.
class Tread {
 public:
  /// mm above the torus.
  double height_at(double cells, double phi) const;
  /// Cells, at phi, of grid line i of 0..kThetaCells.
  double line_at(int i, double phi) const;
  /// Theta of a place, the chevron included.
  static double theta_of(double cells, double phi);
  struct PhiLine {
    double phi = 0.0;
    bool coarse = true;  ///< belongs to the even grid; the others are the upper edges of walls
  };
  /// Symmetrical about 0, from edge to edge.
  static std::vector<PhiLine> phi_lines();

 private:
  /// A lateral rib or a sipe blade, at its foot: cells within a pitch, degrees of |Phi|.
  struct Blade {
    double cell_from, cell_to, phi_from, phi_to, height;
  };
  /// The blades between two circumferential ribs, and where the lines of a pitch go: line first moves to
  /// cell second, others between.
  struct Row {
    double cells_per_height;  ///< cells that a wall 1 mm high is wide
    std::vector<Blade> blades;
    std::vector<std::pair<int, double>> lines;
  };
  static Row make_row(double phi, std::vector<Blade> blades, const std::vector<std::pair<int, int>>& ranges);
  static double line_in_row(const Row& row, int line);

  /// Blades that run into a circumferential rib end under its middle.
  const Row rows_[3] = {
      make_row(4.0, {{3.0, 8.0, -11.0, 11.0, 5.0}}, {{3, 9}}),
      make_row(22.0, {{1.0, 3.0, 18.0, 26.0, 4.0}, {11.0, 16.0, 11.0, 33.0, 7.0}}, {{1, 4}, {11, 17}}),
      make_row(43.0, {{3.0, 8.0, 33.0, 51.6, 7.0}, {15.0, 17.0, 40.0, 50.0, 4.0}}, {{3, 9}, {15, 18}}),
  };
};

}  // namespace tiltfeed::sim
