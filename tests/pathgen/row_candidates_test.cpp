// What is found for all rows at once, against the bins that are asked row by row: the same candidates.
#include "pathgen/surface/row_candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <tuple>

#include "pathgen/pattern/row_layout.h"
#include "tests/shapes/turned_parts.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

struct Part360 {
  std::string name;
  CheckedMesh part;
  AxisFrame frame;
  double rho;
};

/// Bodies that lie all round their axis feature, so that coordinates wrap.
std::vector<Part360> parts() {
  Outline tube;
  for (int i = 0; i <= 24; ++i)
    tube.push_back({60.0 + 12.0 * std::cos(2.0 * kPi * i / 24), 12.0 * std::sin(2.0 * kPi * i / 24)});
  tube.back() = tube.front();
  Stl ring;
  revolve(tube, 48, ring);
  const CheckedMesh ball = solid_ball(20.0, 24);
  const Vec3 x{1, 0, 0}, z{0, 0, 1};
  return {{"fixed", ball, {AxisMode::kFixed, Sense::kOutward, {}, x, z, 0.0}, 20.0},
          {"point", ball, {AxisMode::kPoint, Sense::kOutward, {}, x, z, 0.0}, 20.0},
          {"line", ball, {AxisMode::kLine, Sense::kOutward, {}, x, z, 0.0}, 15.0},
          {"circle", checked(ring), {AxisMode::kCircle, Sense::kOutward, {}, x, {0, 1, 0}, 60.0}, 12.0}};
}

/// All rows, each in two pieces with a gap at a place by chance.
std::vector<FlatLine> pieces_of_rows(const RowLayout& raster, std::mt19937& random) {
  std::vector<FlatLine> lines;
  for (double k = 0.0; k < raster.count; ++k) {
    const FlatLine row = raster.row(k);
    const double half = row.length * (0.2 + 0.6 * (random() * 0x1.0p-32)), rest = half + 0.1 * row.length;
    lines.push_back({row.x, row.y, row.dx, row.dy, half});
    lines.push_back({row.x_at(rest), row.y_at(rest), row.dx, row.dy, row.length - rest});
  }
  return lines;
}

bool same(const Candidate& a, const Candidate& b) {
  return std::tie(a.from, a.to, a.patch, a.top) == std::tie(b.from, b.to, b.patch, b.top);
}

/// Is one of `found` the same but longer or higher?
bool covers(const std::vector<Candidate>& found, const Candidate& c) {
  return std::any_of(found.begin(), found.end(), [&](const Candidate& f) {
    return f.patch == c.patch && f.from <= c.from && f.to >= c.to && f.top >= c.top;
  });
}

TEST(RowCandidates, GivesEachRowWhatTheBinsGive) {
  PlanOptions options;
  options.cutter.diameter = 4.0, options.cutter.length = 60.0, options.cutter.shank_length = 20.0;
  std::mt19937 random(5);
  for (const Part360& p : parts()) {
    const ClSurface surface(p.part.mesh, p.part.sides, tool_pieces(options));
    const Deformation map(p.frame, p.rho);
    const FlatIndex index(make_flat_hulls(surface, map, 1.0), map);
    for (const double degrees : {0.0, 90.0, 31.0}) {
      SCOPED_TRACE(p.name + ", rows at " + std::to_string(degrees));
      Pattern pattern;
      pattern.angle = Angle::from_degrees(degrees);
      const auto raster = lay_rows(index, index.bounds(), pattern, 1.5);
      ASSERT_TRUE(raster) << raster.error().message;
      const std::vector<FlatLine> lines = pieces_of_rows(*raster, random);
      const RowCandidates rows(index, lines);
      std::vector<Candidate> cells;
      FlatIndex::Scratch scratch;
      std::size_t met = 0;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        std::vector<Candidate> found, expected;
        rows.of(i, cells);
        FlatIndex::along(lines[i], cells, scratch, found);
        index.along(lines[i], scratch, expected);
        // Beside a slanted row the bins leave out what only the pads' corners reach.
        if (degrees == 31.0) {
          for (const Candidate& c : expected) EXPECT_TRUE(covers(found, c)) << "line " << i;
        } else {
          EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end(), same))
              << "line " << i;
        }
        met += found.size();
      }
      EXPECT_GT(met, lines.size());
    }
  }
}

TEST(RowCandidates, HasNothingForNoLines) {
  const CheckedMesh ball = solid_ball(20.0, 24);
  PlanOptions options;
  options.cutter.diameter = 4.0, options.cutter.length = 60.0, options.cutter.shank_length = 20.0;
  const ClSurface surface(ball.mesh, ball.sides, tool_pieces(options));
  const Deformation map({AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 20.0);
  const FlatIndex index(make_flat_hulls(surface, map, 1.0), map);
  EXPECT_NO_THROW(RowCandidates(index, {}));
  const FlatLine far{1000.0, 1000.0, 1.0, 0.0, 5.0};
  std::vector<Candidate> met(1);
  RowCandidates(index, std::vector{far}).of(0, met);
  EXPECT_TRUE(met.empty());
}

}  // namespace
}  // namespace tiltfeed
