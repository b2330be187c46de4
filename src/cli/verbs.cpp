#include "verb.h"

namespace scslam::cli {

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> all = {runVerb(),      evalVerb(),     placesVerb(), compareVerb(),
                                        optimizeVerb(), exportVerb(),   infoVerb(),   listVerb(),
                                        configVerb(),   doctorVerb(),   cleanVerb(),  mergeVerb(),
                                        changesVerb(),  localizeVerb(), simVerb(),    realismVerb()};
  return all;
}

}  // namespace scslam::cli
