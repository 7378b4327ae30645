#pragma once
// A hill on a plate and a waved rod, made by formula, and job files that hold them by fixtures.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/mesh/stl.h"
#include "tests/texts/folder.h"

namespace tiltfeed {

using FacetList = std::vector<std::array<Point<Part>, 3>>;

namespace held {

inline void quad(FacetList& facets, Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
  facets.push_back({a, b, c});
  facets.push_back({a, c, d});
}

/// 40 x 30 mm, 12 mm high at the rim and 18 in the middle; on the plane z = 0.
inline FacetList hill() {
  constexpr int kCells = 16;
  const auto at = [](int i, int j, bool top) {
    const double u = static_cast<double>(i) / kCells, v = static_cast<double>(j) / kCells;
    const double rise = std::sin(kPi * u) * std::sin(kPi * v);
    return Point<Part>{40.0 * (u - 0.5), 30.0 * (v - 0.5), top ? 12.0 + 6.0 * rise * rise : 0.0};
  };
  FacetList facets;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      quad(facets, at(i, j, true), at(i + 1, j, true), at(i + 1, j + 1, true), at(i, j + 1, true));
      quad(facets, at(i, j, false), at(i, j + 1, false), at(i + 1, j + 1, false), at(i + 1, j, false));
    }
  for (int k = 0; k < kCells; ++k) {
    const int n = kCells;
    quad(facets, at(k, 0, false), at(k + 1, 0, false), at(k + 1, 0, true), at(k, 0, true));
    quad(facets, at(k + 1, n, false), at(k, n, false), at(k, n, true), at(k + 1, n, true));
    quad(facets, at(0, k + 1, false), at(0, k, false), at(0, k, true), at(0, k + 1, true));
    quad(facets, at(n, k, false), at(n, k + 1, false), at(n, k + 1, true), at(n, k, true));
  }
  return facets;
}

/// Round z, 40 mm long, of radius 8 to 9.5 mm.
inline FacetList rod() {
  constexpr int kSides = 40, kRings = 16;
  const auto at = [](int i, int k) {
    const double wave = std::sin(2.0 * kPi * k / kRings), radius = 8.0 + 1.5 * wave * wave;
    const double angle = 2.0 * kPi * (i % kSides) / kSides;
    return Point<Part>{radius * std::cos(angle), radius * std::sin(angle), 40.0 * k / kRings};
  };
  FacetList facets;
  for (int i = 0; i < kSides; ++i) {
    for (int k = 0; k < kRings; ++k) quad(facets, at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
    facets.push_back({Point<Part>{0, 0, 0}, at(i + 1, 0), at(i, 0)});
    facets.push_back({Point<Part>{0, 0, 40}, at(i, kRings), at(i + 1, kRings)});
  }
  return facets;
}

}  // namespace held

struct HeldJob {
  std::string name, part, axis;
  std::vector<std::string> fixtures;
  std::string pattern = "{along: x, direction: zigzag, side_step_mm: 3}";
  std::string cutter = "type: ball, diameter_mm: 6";
  std::string more{};  ///< lines of the job file
};

/// A fixture in part coordinates; `at`: the middle of its base.
inline std::string box_fixture(const std::string& name, const std::string& size, const std::string& at) {
  return "{name: " + name + ", on: part, shape: box, size_mm: [" + size + "], at_mm: [" + at + "]}";
}
inline std::string round_fixture(const std::string& name, double diameter, double height,
                                 const std::string& at) {
  return "{name: " + name + ", on: part, shape: cylinder, diameter_mm: " + std::to_string(diameter) +
         ", height_mm: " + std::to_string(height) + ", at_mm: [" + at + "]}";
}

/// Writes part and job; the job's path. The part stands 100 mm over the table's axis point.
inline std::string write_held_job(const Folder& folder, const HeldJob& job) {
  const FacetList facets = job.part == "rod" ? held::rod() : held::hill();
  const std::string stl = folder.path + "/" + job.part + ".stl";
  EXPECT_TRUE(pathgen::write_stl(stl, facets));
  std::string text = "part: {name: " + job.name + ", stl: " + job.part + ".stl}\ncutter: {" + job.cutter +
                     ", length_mm: 90, shank_length_mm: 30, holder: [{diameter_mm: 20, length_mm: 30}, "
                     "{diameter_mm: 40, length_mm: 30}]}\naxis: " +
                     job.axis + "\npattern: " + job.pattern + "\n" + job.more +
                     "tolerance_mm: 0.01\nallowance_mm: 0\nclearance_mm: 5\napproach_mm: 1\n"
                     "feeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 500}\n"
                     "setup: {part_zero_mm: [0, 0, 100]}\nmachine: " SOURCE_DIR
                     "/config/machines/generic-ac.yaml\nfixtures:\n";
  for (const std::string& fixture : job.fixtures) text += "  - " + fixture + "\n";
  return folder.write(job.name + ".yaml", text);
}

}  // namespace tiltfeed
