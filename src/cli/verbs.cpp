#include "verb.h"

namespace scslam::cli {

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> all = [] {
    std::vector<Verb> present;
    for (const auto verb : {runVerb, evalVerb, optimizeVerb, exportVerb, infoVerb, listVerb, configVerb, doctorVerb})
      if (verb != nullptr) present.push_back(verb());
    return present;
  }();
  return all;
}

}  // namespace scslam::cli
