//! Equality of questions and of states of the document.

use std::ptr;
use std::sync::Arc;

/// Shared value that is compared by its address in memory, which is fast for any size.
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

/// Defines equality of a type. Fields after `shared` are compared by address, and fields after `value` by value. Fields
/// after `besides` are ignored. Each field must be in one of the three lists, so that no new field is forgotten.
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
