#pragma once
// The keys `queue`, `queue_ahead` and `plan_for_others` of a service's file: the shop's queue that its
// machine takes jobs from.

#include <string>

#include "config/section.h"

namespace tiltfeed::config {

struct QueueChoice {
  std::string url;    ///< postgresql://...; empty: the service's own spool alone
  bool plans = true;  ///< it plans for other machines while its own does nothing
  int ahead = 1;      ///< jobs of the shop that wait at this machine for their start, at most
};

/// Problems are complaints at the keys; none of them repeats the address.
QueueChoice read_queue(const Section& root);

/// Nothing wrong with the address of a shop's database, as far as it can be seen without libpq. Errors:
/// kInput, without the address: it may have a password in it.
Result<void> check_queue_url(const std::string& url);

/// The address for people, should a password have got into it all the same: "***" in its place.
std::string shown_queue(const std::string& url);

}  // namespace tiltfeed::config
