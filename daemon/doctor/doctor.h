#pragma once
// `tiltfeed doctor`: what stands between a service and its machine. It opens no line and changes nothing.

#include <string>
#include <vector>

#include "config/service_config.h"
#include "daemon/doctor/host.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

enum class Verdict : std::uint8_t {
  kGood,
  kToDo,      ///< the text ends with what to do
  kNotAsked,  ///< nothing is said of it
};
const char* verdict_name(Verdict verdict);

struct Finding {
  Verdict verdict = Verdict::kGood;
  std::string what;  ///< one or two words
  std::string text;
};
using Findings = std::vector<Finding>;

/// Programs beside this one and their versions, processes of a version that was replaced, the clock.
Findings examine_host(const Host& host, const std::string& version);
/// A serial device: there, usable by host.asker and within the unit, in nobody else's hands, left alone by
/// ModemManager and brltty, quick to answer.
Findings examine_device(const Host& host, const std::string& device);
/// Whether host.asker can keep the service's files, a submission of the largest size fits, and a service
/// answers.
Findings examine_places(const Host& host, const config::ServiceConfig& config);

}  // namespace tiltfeed::daemon
