// Every model that is not refused is planned with its placement, and a sample of the path is held against the
// part: no gouge by ball or shank, no rapid through the part, the ball in contact. Models are local test
// data: the cases are those whose files are there, and always the formula parts.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "tests/judges/path_proof.h"
#include "tests/shapes/public_models.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

const std::string kModels = SOURCE_DIR "/../shared/models/";
constexpr double kTolerance = 0.01;
constexpr std::size_t kPoses = 20'000;

struct Row {
  models::Model model;
  std::string formula;  ///< name of a part of sim/parts/parts.h, instead of a file
};

std::vector<Row> rows() {
  std::vector<Row> all;
  for (const models::Model& model : models::all()) {
    if (!model.refused && std::filesystem::exists(kModels + model.file + ".stl")) all.push_back({model, ""});
    for (const char* part : {"tyre", "pin", "sphere", "handle"})
      if (model.file.starts_with(std::string("paper/") + part) &&
          std::none_of(all.begin(), all.end(), [&](const Row& r) { return r.formula == part; }))
        all.push_back({model, part});
  }
  return all;
}

class PublicPlans : public ::testing::TestWithParam<Row> {};

TEST_P(PublicPlans, GetASafePath) {
  const auto& [model, formula] = GetParam();
  Stl stl;
  if (formula.empty()) {
    auto read = read_stl(kModels + model.file + ".stl", model.unit_mm);
    ASSERT_TRUE(read) << read.error().message;
    stl = std::move(*read);
  } else {
    stl.facets = *sim::part_by_name(formula);
  }
  const auto part = check_mesh(stl);
  ASSERT_TRUE(part) << part.error().message;
  PlanOptions o;
  o.name = "model";
  o.axis = model.placement.axis;
  const double ball = model.placement.ball;
  o.cutter = {ball, 40 * ball, std::min(20 * ball, 60.0)};
  o.pattern.side_step = model.placement.side_step;
  o.tolerance = kTolerance;
  o.links.clearance = ball, o.links.approach = ball / 2;
  o.cut_feed = Feed::from_mm_per_min(1000), o.plunge_feed = Feed::from_mm_per_min(300);
  const auto start = std::chrono::steady_clock::now();
  const auto planned = plan(*part, o, nullptr);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_TRUE(planned) << planned.error().message;
  const Measured worst = PathProof(o.axis, o.pattern.along, o.cutter, kTolerance, *part, planned->path)
                             .measure(kPoses, 1 + planned->path.moves.size() / kPoses);
  std::printf(
      "%-32s %8zu facets %8llu points %6llu passes %7.2f s  gouge %.4f  contact %.4f  rapid %.4f  %zu "
      "warnings\n",
      formula.empty() ? model.file.c_str() : formula.c_str(), part->mesh.facets.size(),
      static_cast<unsigned long long>(planned->report.points),
      static_cast<unsigned long long>(planned->report.passes), seconds, worst.gouge, worst.contact,
      worst.rapid_overlap, planned->report.warnings.size());
  for (const std::string& w : planned->report.warnings) std::printf("    %s\n", w.c_str());
  EXPECT_LE(worst.gouge, kTolerance);
  EXPECT_LE(worst.rapid_overlap, kTolerance);
  EXPECT_LE(worst.contact, kTolerance);
  EXPECT_GT(planned->report.points, 50u);
}

INSTANTIATE_TEST_SUITE_P(Models, PublicPlans, ::testing::ValuesIn(rows()), [](const auto& row) {
  std::string name = row.param.formula.empty() ? row.param.model.file : "formula_" + row.param.formula;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

}  // namespace
}  // namespace tiltfeed
