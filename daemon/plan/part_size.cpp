#include "daemon/plan/part_size.h"

#include <algorithm>

namespace tiltfeed::daemon {

namespace {

/// A part is longer than so many cutter diameters, as a rule.
constexpr double kLeastDiameters = 3.0;

struct Unit {
  const char* word;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1.0}, {"inch", 25.4}, {"m", 1000.0}};

std::string lengths(Vec3 size) {
  return number_text(size.x) + " x " + number_text(size.y) + " x " + number_text(size.z) + " mm";
}

}  // namespace

std::string size_text(const pathgen::Box& bounds) { return "part " + lengths(bounds.max - bounds.min); }

std::optional<std::string> unit_warning(const pathgen::Box& bounds, const config::Job& job) {
  const Vec3 size = bounds.max - bounds.min;
  const double longest = std::max({size.x, size.y, size.z});
  const MachineModel& m = job.machine.model;
  const double travel = std::max({m.x.max - m.x.min, m.y.max - m.y.min, m.z.max - m.z.min});
  const double least = kLeastDiameters * job.plan.cutter.diameter;
  const bool small = longest<least, large = longest> travel;
  if (longest <= 0.0 || (!small && !large)) return std::nullopt;
  std::string text =
      "the part is " + lengths(size) +
      (small ? ", shorter than " + number_text(kLeastDiameters) + " diameters of the cutter (" +
                   number_text(job.plan.cutter.diameter) + " mm)"
             : ", longer than the machine's longest travel (" + number_text(travel) + " mm)");
  for (const Unit& unit : kUnits) {
    const double times = unit.mm / job.stl_unit_mm;
    if (longest * times < least || longest * times > travel) continue;
    return text + "; is the file in " + unit.word + "? Then it is " + lengths(size * times) +
           ": set part.unit to " + unit.word;
  }
  return text + "; check part.unit";
}

}  // namespace tiltfeed::daemon
