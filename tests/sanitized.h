#pragma once

// Sanitizers stand in the place of some functions, and take memory of their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LODE_IS_SANITIZED 1
#elif defined(__has_feature)
#define LODE_IS_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define LODE_IS_SANITIZED 0
#endif
