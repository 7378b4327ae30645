#include "desk/service/service_link.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tiltfeed::desk {
namespace {

Result<std::string> judged(const Result<std::string>& reply) {
  if (!reply) return reply;
  const auto json = nlohmann::json::parse(*reply, nullptr, false);
  if (!json.is_object()) return fail(Code::kIo, "the service's answer is not understood");
  const auto text = [&](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const auto ok = json.find("ok");
  if (ok != json.end() && *ok == true) return reply;
  return fail(Code::kUsage, text("error").empty() ? "the service refuses" : text("error"));
}

}  // namespace

void ServiceLink::ask(const std::string& json, Answered answered, const std::vector<int>& files) {
  if (asked_.size() >= kMost)
    return answered(fail(Code::kLimit, "too much is asked of the service at once; ask again"));
  Result<ServiceCall> call = ServiceCall::start(socket_, json + "\n", files);
  if (!call) return answered(tl::unexpected<Error>(call.error()));
  asked_.push_back({std::move(*call), std::move(answered)});
}

std::vector<int> ServiceLink::descriptors() const {
  std::vector<int> all;
  for (const Asked& one : asked_) all.push_back(one.call.descriptor());
  return all;
}

bool ServiceLink::hear(int descriptor) {
  const auto at = std::find_if(asked_.begin(), asked_.end(),
                               [&](const Asked& one) { return one.call.descriptor() == descriptor; });
  if (at == asked_.end()) return false;
  const std::optional<Result<std::string>> reply = at->call.hear();
  if (!reply) return true;
  const Answered answered = std::move(at->answered);
  asked_.erase(at);
  answered(judged(*reply));
  return true;
}

}  // namespace tiltfeed::desk
