// A sample as somebody types it: speed=0.5 kind=box parts[0].x=1. For programs that make samples of types
// that they were not compiled with.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/type.hpp>

namespace takt::model {

/// JSON for sample_bytes() of such words: a field, or a field of a field, and its value as in JSON; what is
/// text or an enumerator may go without quotes. Each word once. Lists are given whole: few=[1,2]. Fails on a
/// word without '=', and with the names that there are on a field that the type does not have; whether a
/// value fits is sample_bytes()'s to say.
Result<std::string> json_of_words(const Type& type, const std::vector<std::string>& words);

/// One word that is an object of JSON is taken as it is, anything else as json_of_words() does.
Result<std::string> json_of_input(const Type& type, const std::vector<std::string>& words);

}  // namespace takt::model
