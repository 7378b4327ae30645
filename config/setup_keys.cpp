#include "config/body_keys.h"
#include "config/job_keys.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {
namespace {

constexpr Range kFixtureAngle{-360.0, 360.0};  // degrees
constexpr Range kTilt = above(0.0, 180.0);     // degrees

}  // namespace

Setup read_setup(const Section& root, pathgen::PlanOptions& plan) {
  const Section section = root.section("setup", {"part_zero_mm", "fixture_rotation_deg", "tilt_max_deg"});
  Setup setup;
  setup.part_zero = section.vector("part_zero_mm", kPartPlace);
  setup.fixture = rotation_by_degrees(section.vector("fixture_rotation_deg", kFixtureAngle, Vec3{}));
  setup.tool_length = plan.cutter.length;
  plan.up = setup.fixture.rows[2];
  plan.tilt_max = Angle::from_degrees(section.number("tilt_max_deg", kTilt, plan.tilt_max.degrees()));
  return setup;
}

}  // namespace tiltfeed::config
