#include "daemon/post/plane_offsets.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/post/dialect.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

/// Of the words' last decimal: nearer places are one.
constexpr double kSamePlace = 0.5;

bool same_place(const PlaneOffset& plane, const Joints& at, int decimals) {
  const auto near = [&](double word, double other) {
    return std::abs(std::remainder(word - other, 360.0)) < kSamePlace / decimal_scale(decimals);
  };
  return near(plane.tilt, at.a) && near(plane.rotary, at.c);
}

std::vector<PlaneOffset>::const_iterator plane_of(const std::vector<PlaneOffset>& planes,
                                                  const Posting& posting, const Operation& op) {
  const Joints& at = op.words->moves.front().joints;
  return std::find_if(planes.begin(), planes.end(), [&](const PlaneOffset& plane) {
    return same_place(plane, at, posting.machine.format.rotary_decimals);
  });
}

}  // namespace

Result<std::vector<PlaneOffset>> plane_offsets(const Posting& posting) {
  std::vector<PlaneOffset> planes;
  if (!posting.data.plane_offsets) return planes;
  for (const Operation& op : posting.operations) {
    if (!op.plane)
      return fail(Code::kInput,
                  "a rotary turns in a cut, so that the program is in no tilted planes, and each plane is to "
                  "have a work offset of its own; state program.plane_offsets: false (--plane-offsets)");
    if (plane_of(planes, posting, op) != planes.end()) continue;
    const Joints& at = op.words->moves.front().joints;
    planes.push_back({posting.data.work_offset + static_cast<int>(planes.size()), at.a, at.c});
  }
  const config::Dialect dialect = posting.machine.format.dialect;
  const int most = config::most_work_offsets(dialect);
  if (!planes.empty() && planes.back().offset > most)
    return fail(Code::kLimit,
                "the program's " + std::to_string(planes.size()) + " planes need the work offsets " +
                    std::to_string(planes.front().offset) + " to " + std::to_string(planes.back().offset) +
                    ", and " + config::name_of(dialect).name + " programs can call " + std::to_string(most) +
                    "; begin with a lower program.work_offset, or divide the job");
  return planes;
}

int offset_of(const std::vector<PlaneOffset>& planes, const Posting& posting, const Operation& op) {
  const auto plane = plane_of(planes, posting, op);
  return plane == planes.end() ? posting.data.work_offset : plane->offset;
}

std::vector<std::string> offset_remarks(const std::vector<PlaneOffset>& planes,
                                        const config::MachineProfile& machine) {
  std::vector<std::string> texts;
  if (!planes.empty()) texts.emplace_back("each plane has its own work offset, all at part zero");
  for (const PlaneOffset& plane : planes) {
    std::string text = "work offset " + work_offset_word(machine.format.dialect, plane.offset) + " at";
    for (const auto& [axis, word] :
         {std::pair{&machine.model.tilt, plane.tilt}, std::pair{&machine.model.rotary, plane.rotary}})
      if (axis->present) text += std::string(" ") + axis->letter + decimal(word, 4);
    texts.push_back(std::move(text));
  }
  return texts;
}

}  // namespace tiltfeed::daemon
