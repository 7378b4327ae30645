// A job whose part is a CAD file, against the same job with the part's exact formula as a fine mesh; what of
// the file is chosen, in which unit, and what is refused.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>

#include "config/part_reading.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/plan/plan.h"
#include "tests/cad/cad_shapes.h"
#include "tests/cad/made_files.h"

namespace tiltfeed {
namespace {

using namespace cad_shapes;
constexpr double kTolerance = 0.01;

std::string job_text(const std::string& part, const std::string& more = "") {
  return "part: {name: part, stl: " + part + more + R"(}
cutter: {type: ball, diameter_mm: 6, length_mm: 80, shank_length_mm: 40}
axis: {mode: fixed}
pattern: {kind: raster, side_step_mm: 1.5}
containment: {x_mm: [3, 27], y_mm: [3, 27]}
tolerance_mm: 0.01
clearance_mm: 5
approach_mm: 1
feeds: {cut_mm_per_min: 2000, plunge_mm_per_min: 600}
setup: {part_zero_mm: [0, 0, 100]}
machine: )" +
         SOURCE_DIR + "/config/machines/generic-ac.yaml\n";
}

config::Job job_of(const std::string& part, const std::string& more = "") {
  const auto job = config::parse_job(job_text(part, more), "job.yaml");
  EXPECT_TRUE(job) << job.error().message;
  return job ? *job : config::Job{};
}

/// Rows by y: heights of the tip over x.
std::map<long, std::map<double, double>> rows_of(const config::Job& job) {
  const auto part = config::read_part(job);
  EXPECT_TRUE(part) << part.error().message;
  if (!part) return {};
  EXPECT_EQ(part->sides, pathgen::Sides::kOutward);
  const auto plan = pathgen::plan(*part, job.plan, [](const char*, double) { return true; });
  EXPECT_TRUE(plan) << plan.error().message;
  std::map<long, std::map<double, double>> rows;
  if (!plan) return rows;
  for (const Move& move : plan->path.moves)
    if (move.kind == MoveKind::kCut)
      rows[std::lround(move.pose.tip.y * 1e6)][move.pose.tip.x] = move.pose.tip.z;
  // What is no row joins two.
  std::erase_if(rows, [](const auto& row) { return row.second.size() < 5; });
  return rows;
}

struct Height {
  double height = 0.0, slope = 0.0;
};
/// On the straight moves between the points of a row.
std::optional<Height> on_row(const std::map<double, double>& row, double x) {
  const auto after = row.upper_bound(x);
  if (after == row.end() || after == row.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double slope = (after->second - before->second) / (after->first - before->first);
  return Height{before->second + slope * (x - before->first), slope};
}

/// The block of the spline as facets far finer than the tolerance.
std::string formula_mesh(const Folder& folder) {
  constexpr int kCells = 500;
  std::vector<std::array<Point<Part>, 3>> facets;
  const auto at = [&](int i, int j, double down) {
    const double x = 30.0 * i / kCells, y = 30.0 * j / kCells;
    return Point<Part>{x, y, patch_height(x, y) - down};
  };
  const auto quad = [&](Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
    facets.push_back({a, b, c}), facets.push_back({a, c, d});
  };
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      quad(at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0));
      quad(at(i, j, 20), at(i, j + 1, 20), at(i + 1, j + 1, 20), at(i + 1, j, 20));
    }
    quad(at(i, 0, 20), at(i + 1, 0, 20), at(i + 1, 0, 0), at(i, 0, 0));
    quad(at(i + 1, kCells, 20), at(i, kCells, 20), at(i, kCells, 0), at(i + 1, kCells, 0));
    quad(at(0, i + 1, 20), at(0, i, 20), at(0, i, 0), at(0, i + 1, 0));
    quad(at(kCells, i, 20), at(kCells, i + 1, 20), at(kCells, i + 1, 0), at(kCells, i, 0));
  }
  const std::string path = folder.path + "/formula.stl";
  EXPECT_TRUE(pathgen::write_stl(path, facets));
  return path;
}

TEST(CadPlan, IsThatOfTheExactFormulaWithinTheTolerance) {
  const Folder folder("cad_plan");
  const config::Job job = job_of(cad_file("spline.step")), truth = job_of(formula_mesh(folder));
  EXPECT_DOUBLE_EQ(truth.plan.tolerance, kTolerance);
  EXPECT_DOUBLE_EQ(job.tessellation, ToleranceBudget::tessellation(kTolerance));
  EXPECT_DOUBLE_EQ(job.plan.tolerance + job.tessellation, kTolerance);
  const auto rows = rows_of(job), exact = rows_of(truth);
  ASSERT_EQ(rows.size(), exact.size());
  ASSERT_GT(rows.size(), 10u);
  std::size_t compared = 0;
  double most = 0.0;
  for (const auto& [y, row] : rows) {
    ASSERT_TRUE(exact.contains(y)) << y;
    for (double x = 3.0; x < 27.0; x += 0.05) {
      const auto here = on_row(row, x), there = on_row(exact.at(y), x);
      if (!here || !there) continue;
      most = std::max(most,
                      std::abs(here->height - there->height) / std::sqrt(1.0 + there->slope * there->slope));
      ++compared;
    }
  }
  EXPECT_GT(compared, 7000u);
  EXPECT_LE(most, kTolerance);
  RecordProperty("largest_difference_um", static_cast<int>(std::lround(1e3 * most)));
}

TEST(CadPlan, BodiesByName) {
  const std::string path = cad_file("assembly.step");
  const auto size = [&](const std::string& more) {
    const auto part = config::read_part(job_of(path, more));
    EXPECT_TRUE(part) << part.error().message;
    return part ? part->bounds.max - part->bounds.min : Vec3{};
  };
  EXPECT_NEAR(size("").y, 96.0, 0.01);  // from the ball to the second block
  EXPECT_NEAR(size(", bodies: block").y, 90.0, 1e-6);
  EXPECT_NEAR(size(", bodies: [\"block (2)\"]").y, 30.0, 1e-6);
  EXPECT_NEAR(size(", bodies: [knob]").x, 12.0, 0.01);
  const auto refused = config::read_part(job_of(path, ", bodies: [lid]"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find(
                "no body has the name \"lid\"; there are \"block\", \"block (2)\", \"knob\""),
            std::string::npos)
      << refused.error().message;
}

TEST(CadPlan, UnitsAreTheFilesOwn) {
  for (const char* file : {"box_inch.step", "box_inch.iges", "box.iges"}) {
    const auto part = config::read_part(job_of(cad_file(file)));
    ASSERT_TRUE(part) << part.error().message;
    EXPECT_NEAR(part->bounds.max.x, 40.0, 1e-6) << file;
    EXPECT_NEAR(part->bounds.max.y, 30.0, 1e-6) << file;
  }
  const auto refused = config::read_part(job_of(cad_file("box_inch.step"), ", unit: inch"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("the file states its own; remove part.unit"), std::string::npos);
}

/// Two of a face's references swapped for others: whatever OpenCASCADE makes of it, there is a reason or a
/// closed part.
TEST(CadPlan, DamagedFilesAreRefusedWithAReason) {
  const Folder folder("cad_plan_damaged");
  const std::string good = file_text(cad_file("pocket.step"));
  std::size_t refused = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    std::string text = good;
    const std::size_t at = text.find('#', text.find("DATA;") + (text.size() / 2 / 12) * i + 40);
    text.replace(at, 2, "#9");
    const auto part = config::read_part(job_of(folder.write("damaged.step", text)));
    if (part) continue;
    ++refused;
    EXPECT_NE(part.error().message.find('#'), std::string::npos) << part.error().message;
  }
  EXPECT_GT(refused, 6u);
}

}  // namespace
}  // namespace tiltfeed
