#include "desk/webhooks/webhooks.h"

#include <algorithm>
#include <ctime>
#include <random>
#include <stop_token>
#include <thread>
#include <utility>

#include "desk/webhooks/delivery_lane.h"
#include "desk/webhooks/event_watch.h"

namespace tiltfeed::desk {
namespace {

using Clock = std::chrono::steady_clock;

std::string name_of_lane(std::size_t lane, const config::Webhook& hook) {
  return "webhooks[" + std::to_string(lane + 1) + "] (" + hook.host + "): ";
}

}  // namespace

struct Webhooks::Work {
  Work(const WebhookOptions& options, std::function<void(const std::string&)> its_log,
       DeliveryStore its_store, HttpPosts its_posts, const KnownService& known)
      : log(std::move(its_log)),
        store(std::move(its_store)),
        posts(std::move(its_posts)),
        socket(options.socket),
        watch(options.socket, known,
              {[this](const KnownService& k, const std::vector<HookMessage>& m) { return keep(k, m); },
               [this](const std::string& text) { log("webhooks: " + text); }}) {
    for (std::size_t i = 0; i < options.hooks.size(); ++i)
      lanes.emplace_back(
          options.hooks[i], store,
          [this, name = name_of_lane(i, options.hooks[i])](const std::string& text) { log(name + text); });
  }

  void run(const std::stop_token& stop);
  bool keep(const KnownService& known, const std::vector<HookMessage>& messages);
  void begin_due(Clock::time_point now, std::int64_t wall);
  std::chrono::milliseconds patience(Clock::time_point now) const;
  void tell_counts();

  std::function<void(const std::string&)> log;
  DeliveryStore store;
  HttpPosts posts;
  std::string socket, kept_not;
  EventWatch watch;
  std::vector<DeliveryLane> lanes;
  std::uint64_t dropped = 0;
  std::mt19937_64 random{std::random_device{}()};
  std::jthread thread;  // the last: it ends before the others
};

bool Webhooks::Work::keep(const KnownService& known, const std::vector<HookMessage>& messages) {
  std::vector<Addressed> all;
  for (const HookMessage& message : messages)
    for (const DeliveryLane& lane : lanes)
      if (message.fault ? lane.hook().fault : lane.hook().done) all.push_back({lane.hook().url, message});
  const Result<std::uint64_t> kept = store.keep(socket, known, all, std::time(nullptr));
  if (!kept) {
    if (kept.error().message != kept_not) log("webhooks: " + kept.error().message + "; it is tried again");
    kept_not = kept.error().message;
    return false;
  }
  kept_not.clear();
  if (*kept > 0)
    log("webhooks: " + std::to_string(*kept) + " messages are dropped, the oldest: more than " +
        std::to_string(DeliveryStore::kMostWaiting) + " wait for a receiver");
  dropped += *kept;
  for (DeliveryLane& lane : lanes) lane.wake();
  return true;
}

void Webhooks::Work::begin_due(Clock::time_point now, std::int64_t wall) {
  const auto chance = [this] { return std::uniform_real_distribution<double>(0.0, 1.0)(random); };
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    if (!lanes[i].look(now, wall)) continue;
    const DeliveryLane::Request request = lanes[i].begin(wall);
    if (!posts.start(i, lanes[i].hook().url, request.headers, request.body))
      lanes[i].end({0, "it cannot be asked: no memory, or no such URL", {}, {}}, chance(), now, wall);
  }
  for (const HttpPosts::Ended& ended : posts.turn()) lanes[ended.lane].end(ended.answer, chance(), now, wall);
}

std::chrono::milliseconds Webhooks::Work::patience(Clock::time_point now) const {
  std::chrono::milliseconds most = watch.patience(now);
  for (const DeliveryLane& lane : lanes) most = lane.patience(now, most);
  return most;
}

void Webhooks::Work::run(const std::stop_token& stop) {
  const std::stop_callback wake(stop, [this] { posts.wake(); });
  while (!stop.stop_requested()) {
    const Clock::time_point now = Clock::now();
    const std::int64_t wall = std::time(nullptr);
    watch.look(now, wall);
    begin_due(now, wall);
    const std::vector<int> heard = watch.descriptors();
    posts.wait(patience(now), heard);
    for (const int fd : heard) watch.hear(fd);
  }
  tell_counts();
}

void Webhooks::Work::tell_counts() {
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const LaneCounts& n = lanes[i].counts();
    const std::uint64_t waiting = store.waiting(lanes[i].hook().url).value_or(0);
    if (n.taken + n.in_vain + n.refused + waiting == 0) continue;
    log(name_of_lane(i, lanes[i].hook()) + std::to_string(n.taken) + " taken, " + std::to_string(n.refused) +
        " refused, " + std::to_string(n.given_up) + " given up, " + std::to_string(n.in_vain) +
        " tries in vain, " + std::to_string(waiting) + " wait for the next start");
  }
  if (dropped > 0) log("webhooks: " + std::to_string(dropped) + " were dropped for room");
}

Webhooks::Webhooks(std::unique_ptr<Work> work) : work_(std::move(work)) {}
Webhooks::~Webhooks() = default;

Result<std::unique_ptr<Webhooks>> Webhooks::start(const WebhookOptions& options,
                                                  std::function<void(const std::string&)> log) {
  if (options.socket.empty())
    return fail(Code::kUsage, "webhooks are about a machine: start with --beside FILE or --service SOCKET");
  Result<DeliveryStore> store = DeliveryStore::open(options.state);
  if (!store) return tl::unexpected<Error>(store.error());
  Result<HttpPosts> posts = HttpPosts::make();
  if (!posts) return tl::unexpected<Error>(posts.error());
  const Result<KnownService> known = store->known(options.socket);
  if (!known) return tl::unexpected<Error>(known.error());
  std::vector<std::string> urls;
  for (const config::Webhook& hook : options.hooks) urls.push_back(hook.url);
  const Result<std::uint64_t> others = store->drop_others(urls);
  if (!others) return tl::unexpected<Error>(others.error());
  if (*others > 0)
    log("webhooks: " + std::to_string(*others) + " messages are dropped: their URLs are not named any more");
  auto work = std::make_unique<Work>(options, std::move(log), std::move(*store), std::move(*posts), *known);
  work->thread = std::jthread([w = work.get()](const std::stop_token& stop) { w->run(stop); });
  return std::unique_ptr<Webhooks>(new Webhooks(std::move(work)));
}

}  // namespace tiltfeed::desk
