//! When two questions, or two states of the document, are the same.

use std::ptr;
use std::sync::Arc;

/// What is shared and known by its place in memory: comparing it costs nothing, however much it holds.
pub trait Shared {
    /// Where it is.
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

/// Makes two values equal where the fields after `shared` are at the same place in memory and those after `value` are equal; those after
/// `besides` play no part. Each field must stand in one of the three lists, so a new one cannot be forgotten.
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
