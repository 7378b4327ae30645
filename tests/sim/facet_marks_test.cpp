// sim/facet_marks: what no cut comes near, and what the planner's report says is out of reach.

#include "sim/picture/facet_marks.h"

#include <gtest/gtest.h>

#include "tests/shapes/soup.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

/// A cube of 40 mm, and passes 2 mm apart over its top with a ball of radius 3; `over`: the tip over the top.
struct Milled {
  CheckedMesh part = soup::check(soup::cube(0, 40));
  Job job;
  ToolPath path;
  explicit Milled(double over) {
    job.plan.cutter = {.diameter = 6, .length = 60, .shank_length = 40};
    job.plan.pattern.side_step = 2.0;
    job.plan.tolerance = 0.01;
    job.plan.axis.mode = AxisMode::kFree;
    for (int i = 0; i <= 20; ++i) {
      const double y = 2.0 * i;
      path.moves.push_back({{{0, y, 60}, {0, 0, 1}}, MoveKind::kRapid});
      path.moves.push_back({{{0, y, 40 + over}, {0, 0, 1}}, MoveKind::kPlunge});
      path.moves.push_back({{{40, y, 40 + over}, {0, 0, 1}}, MoveKind::kCut});
      path.moves.push_back({{{40, y, 60}, {0, 0, 1}}, MoveKind::kRapid});
    }
  }
  std::vector<FacetMark> marks(const std::string& report) const {
    return *facet_marks(part.mesh, job, path, report);
  }
  bool on_top(std::size_t f) const {
    for (const std::uint32_t v : part.mesh.facets[f])
      if (part.mesh.vertices[v].z < 40.0) return false;
    return true;
  }
};

TEST(FacetMarks, OnlyWhatAPassComesNearIsCut) {
  const Milled milled(0.0);
  const auto marks = milled.marks("");
  std::size_t cut = 0;
  for (std::size_t f = 0; f < marks.size(); ++f) {
    EXPECT_EQ(marks[f], milled.on_top(f) ? FacetMark::kNone : FacetMark::kUncut) << f;
    cut += marks[f] == FacetMark::kNone ? 1 : 0;
  }
  EXPECT_EQ(cut, 2u);
}

TEST(FacetMarks, APassTooHighLeavesTheTopUncut) {
  // Passes 2 mm apart may leave a ridge of 0.35 mm where planes cut at 45 degrees.
  for (const auto& [over, mark] : {std::pair{0.25, FacetMark::kNone}, std::pair{0.4, FacetMark::kUncut}}) {
    const Milled milled(over);
    const auto marks = milled.marks("");
    for (std::size_t f = 0; f < marks.size(); ++f)
      EXPECT_EQ(marks[f], milled.on_top(f) ? mark : FacetMark::kUncut) << over << " facet " << f;
  }
}

TEST(FacetMarks, UnreachedFacetsAreThoseOfTheReport) {
  const Milled milled(0.0);
  const auto marks = milled.marks(R"({"free": {"unreached_facets": [{"facet": 3, "why": "holder"}]}})");
  for (std::size_t f = 0; f < marks.size(); ++f)
    EXPECT_EQ(marks[f] == FacetMark::kUnreached, milled.part.mesh.source[f] == 3) << f;
  EXPECT_EQ(milled.marks(R"({"part": "x"})"), milled.marks(""));
}

TEST(FacetMarks, UncutFacetsOfAnAxisFieldAreThoseOfTheReport) {
  Milled milled(0.0);
  milled.job.plan.axis.mode = AxisMode::kFixed;
  const auto marks = milled.marks(R"({"uncut": {"facets": [{"facet": 2, "why": "cutter", "share": 0.75},
                                                            {"facet": 3, "why": "wall", "share": 0.25}]}})");
  for (std::size_t f = 0; f < marks.size(); ++f)
    EXPECT_EQ(marks[f], milled.part.mesh.source[f] == 2 ? FacetMark::kUncut : FacetMark::kNone) << f;
}

TEST(FacetMarks, WhatIsNoReportIsRefused) {
  const Milled milled(0.0);
  for (const char* text : {"G21 G90", "[1, 2]", "{\"free\": "}) {
    const auto marks = facet_marks(milled.part.mesh, milled.job, milled.path, text);
    ASSERT_FALSE(marks) << text;
    EXPECT_EQ(marks.error().code, Code::kInput);
  }
}

}  // namespace
}  // namespace tiltfeed::sim
