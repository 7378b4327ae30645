#include "daemon/service/run_place.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/protocol/grbl_words.h"

namespace tiltfeed::daemon {

std::string run_place_json(const SendState& state) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(state.place[i])) json["program"][std::string(1, kAxisLetters[i])] = state.place[i];
  const auto tell = [&](const char* name, int percent) {
    if (percent != 0) json["override"][name] = percent;
  };
  tell("feed", state.feed_override);
  tell("rapid", state.rapid_override);
  tell("spindle", state.spindle_override);
  if (state.feed >= 0.0) json["feed_mm_per_min"] = state.feed;
  if (state.spindle >= 0.0) json["spindle_rpm"] = state.spindle;
  if (!state.machine.empty()) json["words"] = grbl_state_text(state.machine, 0);
  return json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tiltfeed::daemon
