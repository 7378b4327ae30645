#pragma once
// What a job needs of a machine, read from its own files before it goes to the shop.

#include <string>
#include <vector>

#include "daemon/shop/shop_fit.h"

namespace tiltfeed::daemon {

struct ShopWishes {
  std::string machine;             ///< profile (YAML) that a program was made for; empty: none
  bool any_values = false;         ///< the profile's name is enough
  bool any_machine = false;        ///< of a job that is planned where it runs: whatever the profile
  std::vector<std::string> tools;  ///< ids of a tool library, or numbers, besides those that are found
};

struct FoundNeeds {
  ShopNeeds needs;
  std::string unread;  ///< what of a program could not be read, for people; empty: nothing
};

/// A program: profile, its values and dialect; where its words are axis positions, how far each axis goes;
/// its tool changes (the dialects rs274 and grbl). A job: the name of its profile, its tool. Errors: kUsage:
/// a program without a profile; those of the files.
Result<FoundNeeds> find_needs(const std::string& file, bool program, const ShopWishes& wishes);

}  // namespace tiltfeed::daemon
