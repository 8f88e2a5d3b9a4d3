// A sample as a person types it: speed=0.5 kind=box pose.x=1. For programs that build samples of types that
// they were not compiled with.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/type.hpp>

namespace takt::model {

/// Converts such words to JSON for sample_bytes(). A word is FIELD=VALUE. FIELD may be a field of a field,
/// and VALUE is written as in JSON. Texts and enumerators need no quotes. A list is given as a whole:
/// few=[1,2]. Fails on a word without '=', on a field that is given twice, and on an unknown field; the
/// problem then lists the known fields. sample_bytes() checks whether the values fit.
Result<std::string> json_of_words(const Type& type, const std::vector<std::string>& words);

/// Returns a single word that is a JSON object unchanged; converts anything else with json_of_words().
Result<std::string> json_of_input(const Type& type, const std::vector<std::string>& words);

}  // namespace takt::model
