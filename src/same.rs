//! Equality of types whose large fields are compared by their addresses in memory instead of their contents.

use std::ptr;
use std::sync::Arc;

/// Reference-counted value that is compared by its address in memory, which takes the same time for any size.
pub trait Shared {
    fn place(&self) -> *const ();
}

impl<T> Shared for Arc<T> {
    fn place(&self) -> *const () {
        Self::as_ptr(self).cast()
    }
}

impl<T> Shared for Option<Arc<T>> {
    fn place(&self) -> *const () {
        self.as_ref().map_or(ptr::null(), Shared::place)
    }
}

/// Defines the equality of a type. Fields in `shared` are compared by address, fields in `value` by value, and fields in
/// `besides` not at all. The compiler requires each field in one of the three lists, so that none is forgotten.
macro_rules! same_where {
    ($name:ty: shared($($shared:ident),*) value($($value:ident),*) besides($($besides:ident),*)) => {
        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                let Self { $($shared,)* $($value,)* $($besides: _,)* } = self;
                $($crate::same::Shared::place($shared) == $crate::same::Shared::place(&other.$shared) &&)*
                $(*$value == other.$value &&)*
                true
            }
        }
    };
}
pub(crate) use same_where;
