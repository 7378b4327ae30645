// The requests about the shop's queue. None of them moves a machine: what is offered again waits at a machine
// for its operator.

#include <nlohmann/json.hpp>

#include "desk/api/desk.h"
#include "desk/api/replies.h"

namespace tiltfeed::desk {

using nlohmann::json;

Reply Desk::shop(const Request&) { return shop_.view(std::chrono::steady_clock::now()); }

Reply Desk::take_back(const Request& request, const char* command) {
  const json body = json::parse(request.body, nullptr, false);
  const json job = body.is_object() ? body.value("job", json()) : json();
  if (!job.is_number_unsigned() || job.get<std::uint64_t>() == 0)
    return refusal(400, "expected {\"job\": 7}, its number in the shop");
  return shop_.order(request.ticket, command, job.get<std::uint64_t>());
}

Reply Desk::release_job(const Request& request) { return take_back(request, "release"); }

Reply Desk::withdraw_job(const Request& request) { return take_back(request, "withdraw"); }

Reply Desk::raise_shop(const Request& request) {
  const json body = json::parse(request.body, nullptr, false);
  const json confirmed = body.is_object() ? body.value("confirmed", json(false)) : json();
  if (!confirmed.is_boolean()) return refusal(400, "expected {}, or {\"confirmed\": true}");
  if (!confirmed.get<bool>() && shop_.is_shown())
    return text_reply(
        json{{"confirm", shop_.raise_text()}}.dump(-1, ' ', true, json::error_handler_t::replace));
  return shop_.order(request.ticket, "raise", 0);
}

}  // namespace tiltfeed::desk
