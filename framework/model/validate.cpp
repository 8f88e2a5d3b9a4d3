#include <takt/model/validate.hpp>
